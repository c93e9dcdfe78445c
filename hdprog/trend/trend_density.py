"""Density of the trend's hyperparameters, given linearised loops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.information import Linearised
from hdprog.physics.parameters import FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.hyperparameters import LogDensity
from hdprog.trend.kalman_filter import log_evidence
from hdprog.trend.state_space import HYPERPARAMETERS, Steps, Timeline, steps_of
from hdprog.trend.temperature import SeenTests
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import WearPrior

UNWORN = np.array([-4.0] + [0.0] * (len(HYPERPARAMETERS) - 1))
"""Deviates of a drive that hardly wears: evidence can be told wherever others fail."""
FARTHEST_DEVIATE = 6.0
"""Of a hyperparameter from its prior's median, in its prior's spreads."""
MOST_WEAR = 30.0
"""Units up to the last test; one unit leaves an eighth of the teeth's stiffness."""


def believed(deviates: FloatArray, steps: Steps) -> NDArray[np.bool_]:
    """Whether hyperparameters (draws, k), and the wear of their steps, have a density (draws,)."""
    near = np.abs(deviates).max(axis=1) < FARTHEST_DEVIATE
    return np.asarray(near & (steps.passed.sum(axis=1) < MOST_WEAR))


def density(
    tests: Sequence[LoopEvidence],
    loops: Sequence[Linearised],
    state_prior: StatePrior,
    wear_prior: WearPrior,
) -> LogDensity:
    """Log posterior density of the hyperparameters' deviates, states integrated out.

    Parameters
    ----------
    tests : in order
    loops : linearised, in the same order
    state_prior : of the coordinates of a new drive
    wear_prior : in whose deviates the density is
    """
    timeline, _ = Timeline.of(tests, ServiceClock.of(tests), wear_prior)
    seen = SeenTests.of(loops, tests, wear_prior).observations

    def steps_at(deviates: FloatArray) -> tuple[Steps, FloatArray]:
        return steps_of(deviates, timeline, state_prior, wear_prior)

    def log_density(deviates: FloatArray) -> FloatArray:
        steps, scatter = steps_at(deviates)
        inside = believed(deviates, steps)
        if not inside.all():
            steps, scatter = steps_at(np.where(inside[:, None], deviates, UNWORN))
        evidence = log_evidence(steps, scatter, seen)
        inside &= np.isfinite(evidence)
        return np.where(inside, evidence - 0.5 * np.sum(deviates**2, axis=1), -np.inf)

    return log_density
