"""Simulated tests under fixed hyperparameters; two are few enough to know the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.information import Linearised
from hdprog.inference.ridge_coordinates import to_unconstrained
from hdprog.physics.parameters import NAMES
from hdprog.trend.exact_likelihood import Nuisances
from hdprog.trend.gaussian_step import GaussianStep
from hdprog.trend.relinearise import JointPrior, joint_mode
from hdprog.trend.ridge_map import RidgeMap
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior, from_loop, slope, to_loop
from hdprog.trend.wear_prior import read_wear_prior
from tests.trend.stand_in import ALPHA, NEW, PRIOR, WEAR, SimulatedLoop, wearing_drive

T_I = NAMES.index("T_i")
WEAR_PRIOR = read_wear_prior()
STATE_PRIOR = StatePrior.of(PRIOR, WEAR_PRIOR)
FIXED = np.zeros((1, len(HYPERPARAMETERS)))
_PRELOAD, _REST = WEAR_PRIOR.preload_volatility, WEAR_PRIOR.own_volatility
# Preload wanders no more than the rest.
FIXED[0, HYPERPARAMETERS.index("preload_volatility")] = (
    np.log(_REST.median / _PRELOAD.median) / _PRELOAD.log_sd
)


@dataclass(frozen=True)
class Problem:
    """Two tests, the trend between them, and the Gaussian step."""

    tests: list[SimulatedLoop]
    prior: JointPrior
    start: np.ndarray
    step: GaussianStep

    def log_density(self, ridge: np.ndarray) -> np.ndarray:
        """Of ridge coordinates (draws, 16): walkers get along in them."""
        points, density = self.points(ridge)
        off = (points - self.prior.mean).reshape(len(ridge), -1)
        density = density - 0.5 * np.einsum("di,ij,dj->d", off, self.prior.precision, off)
        for number, test in enumerate(self.tests):
            density = density + test.log_likelihood(to_loop(points[:, number]))
        return np.where(np.isfinite(density), density, -np.inf)

    def points(self, ridge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        loop, jacobian = to_unconstrained(ridge.reshape(-1, 8), ALPHA, PRIOR.softplus_scale)
        with np.errstate(all="ignore"):
            wear = from_loop(loop)
            jacobian = jacobian - np.log(slope(wear)).sum(axis=1)
        shape = (len(ridge), len(self.tests))
        return wear.reshape(*shape, 8), jacobian.reshape(shape).sum(axis=1)


def two_tests() -> Problem:
    """Tests at 0 and 1 500 h, linearised at their joint mode."""
    return worn_by([0.6, 0.9], NEW + 0.7 * WEAR, points=80)


def worn_by(wear: Sequence[float], start: np.ndarray, points: int = 200) -> Problem:
    """Tests of a drive whose wear is given, from 0 to 1 500 h, linearised at their joint mode."""
    hours = np.linspace(0.0, 1500.0, len(wear))
    tests = wearing_drive(np.random.default_rng(4), np.array(wear), hours, points=points)
    timeline, _ = Timeline.of(tests, ServiceClock.of(tests), WEAR_PRIOR)
    values = Hyperparameters.of(FIXED, WEAR_PRIOR)
    steps = Steps.of(timeline, values, STATE_PRIOR, WEAR_PRIOR)
    prior = JointPrior.of(steps, float(values.scatter[0]), WEAR_PRIOR.scales)
    mode = joint_mode(tests, from_loop(np.tile(start, (len(wear), 1))), prior)
    step = GaussianStep.of(
        tests, mode, timeline, STATE_PRIOR, WEAR_PRIOR, ALPHA, PRIOR.softplus_scale
    )
    return Problem(tests, prior, mode.points, step)


def straight(maps: list[RidgeMap], tangents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Instead of `onto_ridges`: draws stay on the tangents."""
    return tangents, np.zeros(tangents.shape[:2])


def step_covariance(problem: Problem) -> np.ndarray:
    """(16, 16) of what the tests met, by the Gaussian step."""
    whole = problem.prior.precision.copy()
    for number, test in enumerate(problem.step.tests):
        block = slice(8 * number, 8 * number + 8)
        whole[block, block] += test.loop.precision
    return np.asarray(np.linalg.inv(whole))


@dataclass(frozen=True)
class Counting:
    """The linearised loop, and a count of two at a rate of exp(v + 0.8 ξ), ξ a scaled T_i."""

    loop: Linearised
    point: np.ndarray
    mean: float
    spread: float

    def log_likelihood(self, coordinates: np.ndarray, nuisances: np.ndarray) -> np.ndarray:
        at = from_loop(coordinates)
        off = at - self.point
        pull = self.loop.information - self.loop.precision @ self.point
        log_rate = nuisances[:, 0] + 0.8 * (at[:, T_I] - self.mean) / self.spread
        said = off @ pull - 0.5 * np.einsum("di,ij,dj->d", off, self.loop.precision, off)
        return said + 2 * log_rate - np.exp(log_rate)

    def own_at(self, coordinates: np.ndarray) -> np.ndarray:
        by_state = 0.8 * (from_loop(coordinates[None])[0, T_I] - self.mean) / self.spread
        found = 0.0
        for _ in range(20):
            rate = np.exp(found + by_state)
            found += (2.0 - rate - found) / (rate + 1.0)
        return np.array([found])


def with_a_count(problem: Problem) -> tuple[GaussianStep, float, float]:
    """The first test Gaussian but for a count, the second Gaussian, by `straight` ridges.

    With mean and spread of the first one's T_i before it counts.
    """
    covariance = step_covariance(problem)
    plain = problem.prior.precision @ problem.prior.mean.ravel()
    plain += np.concatenate([test.loop.information for test in problem.step.tests])
    mean, spread = float((covariance @ plain)[T_I]), float(np.sqrt(covariance[T_I, T_I]))
    first, second = problem.step.tests
    slope = np.zeros((1, 8))
    slope[0, T_I] = 0.4 / spread
    own = Nuisances(np.array([0.5]), slope, np.array([[1.6]]))
    counting = replace(first, own=own, exact=Counting(first.loop, first.point, mean, spread))
    step = replace(problem.step, tests=(counting, replace(second, exact=None)))
    return step, mean, spread


def _counted() -> tuple[float, float]:
    grid = np.linspace(-7.0, 7.0, 1401)
    along, own_number = grid[:, None], grid
    log_rate = own_number + 0.8 * along
    log_density = 2 * log_rate - np.exp(log_rate) - 0.5 * (along**2 + own_number**2)
    weight = np.exp(log_density).sum(axis=1)
    weight /= weight.sum()
    expected = weight @ grid
    return float(expected), float(np.sqrt(weight @ (grid - expected) ** 2))


COUNTED = _counted()
"""Mean and spread of ξ by quadrature over (ξ, v)."""
