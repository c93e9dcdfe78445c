"""Draws are put back on a loop's ridge; where there is none, they stay where they are."""

from __future__ import annotations

import numpy as np

from hdprog.trend.bend import Bend
from hdprog.trend.wear_coordinates import from_loop, linearise
from tests.trend.stand_in import ALPHA, NEW, PRIOR, simulated_loop


def test_without_teeth_to_meet_draws_stay_where_they_are() -> None:
    rng = np.random.default_rng(2)
    loop = simulated_loop(0.0, NEW, rng)
    nowhere = from_loop(NEW)
    nowhere[3], nowhere[4] = 69.0, -324.0  # b and T_T of a drive that healed without end
    bend = Bend(nowhere, linearise(loop, from_loop(NEW)), PRIOR.sd, ALPHA, PRIOR.softplus_scale)
    measured = nowhere + 0.1 * rng.standard_normal((20, 8))
    assert not bend.correction(measured).any()
