"""How much a figure may wander between two times of a path: what it does along a finer one."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.config import Limit
from hdprog.forecast.limits import margins
from hdprog.physics.figures import Operation
from hdprog.trend.trend import Paths
from hdprog.trend.wear_coordinates import from_loop
from tests.trend.stand_in import ALPHA, NEW, PRIOR, WEAR

OPERATION = Operation(ALPHA, 63.0, 63.0)
DRAWS, STEPS, EACH = 40, 480, 24
SHARED, OWN = 0.02**2, 0.02**2 * np.arange(1.0, 9.0)


def paths(at: slice, states: np.ndarray, shared: float, own: np.ndarray) -> Paths:
    """Some times of paths, with the variances that are added since the time before."""
    some = states[:, at]
    none = np.zeros((DRAWS, 8))
    return Paths(
        hours=np.arange(float(STEPS + 1))[at],
        states=some,
        direction=np.broadcast_to(WEAR, some.shape),
        shared=np.full(some.shape[:2], shared),
        own=np.broadcast_to(own, some.shape),
        warmer=none,
        mounting=none,
    )


@pytest.mark.parametrize(("shared", "own"), [(SHARED, 0.0 * OWN), (0.0, OWN)])
@pytest.mark.parametrize(
    "limit",
    [
        Limit("secant_stiffness_Nm_per_rad", 12_000.0, "below", 14.0),
        Limit("hysteresis_width_arcmin", 2.5, "above"),
    ],
    ids=lambda limit: limit.quantity,
)
def test_a_figure_wanders_by_its_quadratic_variation(
    limit: Limit, shared: float, own: np.ndarray
) -> None:
    """Squares of 19 200 fine steps add up to the coarse ones' variance, to 1 % and the bends."""
    rng = np.random.default_rng(3)
    walk = np.sqrt(shared / EACH) * rng.standard_normal((DRAWS, STEPS, 1)) * WEAR
    walk = walk + np.sqrt(own / EACH) * rng.standard_normal((DRAWS, STEPS, 8))
    walk = np.concatenate([np.zeros((DRAWS, 1, 8)), walk], axis=1)
    states = from_loop(NEW + 0.6 * WEAR) + np.cumsum(walk, axis=1)
    fine = margins(limit, paths(slice(None), states, 0.0, 0.0 * OWN), PRIOR, OPERATION)
    coarse = margins(limit, paths(slice(0, None, EACH), states, shared, own), PRIOR, OPERATION)
    np.testing.assert_allclose(coarse.margin, fine.margin[:, ::EACH])
    gathered = np.sum(np.diff(fine.margin, axis=1) ** 2)
    assert np.sum(coarse.wander[:, 1:]) == pytest.approx(gathered, rel=0.06)
