"""What a drive's tests say of how it wears, any prior left out: what other drives may learn."""

from __future__ import annotations

import numpy as np

from hdprog.physics.parameters import NAMES
from hdprog.trend.fleet import Said
from hdprog.trend.state_space import HYPERPARAMETERS
from hdprog.trend.trend import Trend

DEVIATES: tuple[str, ...] = (*HYPERPARAMETERS, *(f"loading_{name}" for name in NAMES))
"""Hyperparameters, then changes of the coordinates per unit of wear."""
_DRAWS = 2000


def what_tests_say(trend: Trend, rng: np.random.Generator) -> Said:
    """Likelihood of the deviates `DEVIATES` of the wear prior's file, as a Gaussian.

    Parameters
    ----------
    trend : as fitted
    rng : source of randomness
    """
    fleet, size = trend.wear_prior.fleet, len(DEVIATES)
    mean, covariance = np.zeros(size), np.eye(size)
    if fleet is not None:
        mean, covariance = fleet.mean, fleet.covariance
    worth = min(trend.draws.ess_bulk, trend.draws.ess_tail, _DRAWS, trend.met.worth or np.inf)
    return Said.of(np.hstack(trend.deviates(rng, _DRAWS)), mean, covariance, worth)
