"""Where preload and friction share their product otherwise, a record's first slip is another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.sampling_plan import QUICK
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.parameters import NAMES
from hdprog.physics.torque_path import TorquePath
from hdprog.trend.gaussian_step import GaussianStep, Tangents
from hdprog.trend.loop_evidence import FittedLoop
from hdprog.trend.relinearise import JointPrior, joint_mode
from hdprog.trend.ridge_paths import RidgePath, ridge_paths
from hdprog.trend.state_space import Hyperparameters, Steps, Timeline
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import from_loop, to_loop
from tests.trend.stand_in import PRIOR
from tests.trend.two_tests import FIXED, STATE_PRIOR, WEAR_PRIOR

FRICTION = [NAMES.index(name) for name in ("c", "T_i", "mu")]


DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
STICKY = {
    "K_F": 88_800.0,
    "K_W": 80_400.0,
    "a": 3490.0,
    "b": 13_400.0,
    "T_T": 4.1,
    "c": -1.012,
    "T_i": 175.0,
    "mu": 0.263,
}
"""Slip is not over at the largest torque; c, T_i and mu make up for each other."""


def record(rng: np.random.Generator) -> Loop:
    """A loop to 80 Nm that begins near one of its branches."""
    turns = np.array([0.0, 80.0, -80.0, 80.0])
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    at = np.union1d(np.linspace(0.0, travel[-1], 200), travel)
    path = TorquePath.exact(np.interp(at, travel, turns))
    values = {name: np.array([value]) for name, value in STICKY.items()}
    angle = torsion_angle(path, values, DRIVE.alpha, initial_fraction=np.array([0.8]))[0]
    return Loop(path.torque, angle + 1e-5 * rng.standard_normal(at.size), time=at / 2.0)


@pytest.fixture(scope="module")
def step() -> GaussianStep:
    rng = np.random.default_rng(2)
    fits = [fit_loop(record(rng), DRIVE, rng, prior=PRIOR, plan=QUICK) for _ in range(2)]
    tests = [FittedLoop.of(fit, hours) for fit, hours in zip(fits, (0.0, 500.0), strict=True)]
    timeline, _ = Timeline.of(tests, ServiceClock.of(tests), WEAR_PRIOR)
    values = Hyperparameters.of(FIXED, WEAR_PRIOR)
    steps = Steps.of(timeline, values, STATE_PRIOR, WEAR_PRIOR)
    prior = JointPrior.of(steps, float(values.scatter[0]), WEAR_PRIOR.scales)
    start = np.stack([from_loop(test.posterior.mean(axis=0)) for test in tests])
    mode = joint_mode(tests, start, prior)
    return GaussianStep.of(
        tests, mode, timeline, STATE_PRIOR, WEAR_PRIOR, DRIVE.alpha, PRIOR.softplus_scale
    )


def fallen(step: GaussianStep, path: RidgePath, together: bool) -> float:
    """By how much the loops' log likelihoods fall a spread to either side, at most.

    Or at the path's end, where that is nearer: what lies past it has no weight to speak of.
    """
    points = np.stack([test.point for test in step.tests])
    states = np.repeat(points[None], 3, axis=0)
    ends = path.places[[0, -1]] - points.ravel() @ path.share
    by = np.clip(np.array([-1.0, 0.0, 1.0]) * path.spread, *ends)
    shift = path.along(states, by)
    there = states + shift.states
    drawn = step.own_drawn(there, [np.zeros((3, test.own.mean.size)) for test in step.tests])
    if together:
        still = step.own_drawn(states, [np.zeros((3, test.own.mean.size)) for test in step.tests])
        each = zip(still.nuisances, shift.own, strict=True)
        drawn = Tangents(there, tuple(own + more for own, more in each))
    met, _ = step._onto_ridges(there)
    total = np.zeros(3)
    for place, test in enumerate(step.tests):
        assert test.exact is not None
        loop = to_loop(met[:, place])
        total += test.exact.log_likelihood(loop, drawn.nuisances[place])
    return float(total[1] - min(total[0], total[2]))


def test_along_the_paths_of_friction_own_numbers_go_along(step: GaussianStep) -> None:
    """Left to the Gaussian step they were wrong a spread away, and chains stood still there.

    All chains agreed on two thirds of friction's spread.
    """
    paths = [one for one in ridge_paths(step, FIXED[0]) if one.share[FRICTION].any()]
    left = [fallen(step, path, together=False) for path in paths]
    along = [fallen(step, path, together=True) for path in paths]
    assert max(left) > 50.0
    assert max(along) < 0.3 * max(left)
    assert all(one < other for one, other in zip(along, left, strict=True))
