"""One point of linearisation for all loops: the joint mode of the states behind them.

A loop's likelihood is far from Gaussian along the ridge of its stiffnesses; at its own mode its
curvature is that of the wrong place. All tests are therefore linearised together where the trend
puts them, by damped Gauss-Newton steps on loops and trend at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.inference.information import Linearised
from hdprog.physics.parameters import FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.joint_gaussian import joint_gaussian
from hdprog.trend.state_space import Steps
from hdprog.trend.wear_coordinates import linearise

_TOLERANCE = 0.05  # next step in posterior spreads, per number, at which the climb ends
_STUCK = 0.15  # the same where no step climbs any more: friction's kinks leave the ground rough
_LARGEST_MOVE = 2.0  # of a coordinate in one step
_TRIALS = 12


@dataclass(frozen=True)
class JointPrior:
    """Gaussian of what all tests met, x_j (scatter and warmth included), given hyperparameters.

    Attributes
    ----------
    mean : (tests, n)
    precision : (tests·n, tests·n)
    """

    mean: FloatArray
    precision: FloatArray

    @staticmethod
    def of(steps: Steps, scatter: float, scales: FloatArray) -> JointPrior:
        """From the steps of one draw of the hyperparameters, along the tests."""
        mean, covariance = joint_gaussian(steps, np.array([scatter]), scales)
        return JointPrior(mean[0], np.asarray(np.linalg.inv(covariance[0])))

    def log_density(self, points: FloatArray) -> float:
        """Log density up to a constant at (tests, n)."""
        deviation = (points - self.mean).ravel()
        return float(-0.5 * deviation @ self.precision @ deviation)


@dataclass(frozen=True)
class JointMode:
    """Where the loops are linearised.

    Attributes
    ----------
    points : (tests, n)
    loops : (tests) linearised there
    converged : whether the last step was small against the posterior spread
    steps : Gauss-Newton steps taken
    """

    points: FloatArray
    loops: tuple[Linearised, ...]
    converged: bool
    steps: int


def joint_mode(
    tests: Sequence[LoopEvidence],
    start: FloatArray,
    prior: JointPrior,
    largest_steps: int = 40,
) -> JointMode:
    """Climb to the joint mode of loops and trend.

    Parameters
    ----------
    tests : in order
    start : (tests, n) wear coordinates to start from
    prior : of the coordinates, from the trend
    largest_steps : bound on the number of steps
    """
    points = start.copy()
    loops = [linearise(test, point) for test, point in zip(tests, points, strict=True)]
    height = _height(loops, points, prior)
    damping = 0.0
    for number in range(largest_steps + 1):
        precision, slope = _joint(loops, points, prior)
        step = np.linalg.solve(precision, slope)
        left = float(np.sqrt(max(float(step @ slope), 0.0) / points.size))
        if left <= _TOLERANCE or number == largest_steps:
            break
        for _ in range(_TRIALS):
            move = np.linalg.solve(precision + damping * np.diag(np.diag(precision)), slope)
            move *= min(1.0, _LARGEST_MOVE / float(np.max(np.abs(move))))
            trial = points + move.reshape(points.shape)
            trial_loops = [linearise(test, point) for test, point in zip(tests, trial, strict=True)]
            trial_height = _height(trial_loops, trial, prior)
            if trial_height > height:
                points, loops, height = trial, trial_loops, trial_height
                damping = damping / 10 if damping > 1e-6 else 0.0
                break
            damping = max(10 * damping, 1e-4)
        else:
            break
    return JointMode(points, tuple(loops), left <= _STUCK, number)


def _height(loops: Sequence[Linearised], points: FloatArray, prior: JointPrior) -> float:
    return sum(loop.log_likelihood for loop in loops) + prior.log_density(points)


def _joint(
    loops: Sequence[Linearised], points: FloatArray, prior: JointPrior
) -> tuple[FloatArray, FloatArray]:
    """Joint precision and slope of the log density at the points."""
    count = points.shape[1]
    precision = prior.precision.copy()
    slope = -(prior.precision @ (points - prior.mean).ravel())
    for number, loop in enumerate(loops):
        block = slice(number * count, (number + 1) * count)
        precision[block, block] += loop.precision
        slope[block] += loop.information - loop.precision @ points[number]
    return precision, slope


def joint_precision(mode: JointMode, prior: JointPrior) -> FloatArray:
    """Precision (tests·n, tests·n) of all that the tests met, by Laplace's method."""
    return _joint(mode.loops, mode.points, prior)[0]


def laplace_evidence(mode: JointMode, prior: JointPrior) -> float:
    """Log of the integral over all that the tests met, by Laplace's method, up to a constant."""
    height = _height(mode.loops, mode.points, prior)
    return height - 0.5 * float(np.linalg.slogdet(joint_precision(mode, prior))[1])


def moved(before: FloatArray, after: JointMode, prior: JointPrior) -> float:
    """Distance of two points of linearisation (tests, n) in joint posterior spreads, per number."""
    step = (after.points - before).ravel()
    return float(np.sqrt(step @ joint_precision(after, prior) @ step / step.size))
