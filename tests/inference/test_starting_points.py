"""Modes are found wherever the search begins."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.inference.prepare import prepare
from hdprog.inference.starting_points import starting_points
from tests.benchmarks.calibration.loops import DRIVE, draw


@pytest.mark.parametrize("seed", range(4))
def test_two_preload_torques_are_both_found(seed: int) -> None:
    """A loop drawn from the prior that two thirds of the mass puts well below its largest torque.

    The rest lies at it. Searched from draws of the prior alone, one search in five saw only one.
    """
    drawn = draw(463)
    prepared = prepare(drawn.loop, DRIVE, np.random.default_rng(1), prior=drawn.prior)
    found = starting_points(prepared.likelihood, np.random.default_rng([5, seed]))
    near = [start for start in found if start.deviance < found[0].deviance + 8.0]
    preload = [float(drawn.prior.to_physical(start.point[None, :8])["T_i"][0]) for start in near]
    largest = float(np.abs(drawn.loop.torque).max())
    assert min(preload) < 0.7 * largest
    assert max(preload) > 0.98 * largest
