"""A drive that is tested cold and hot in turn, and whose friction follows the temperature."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.physics.parameters import NAMES
from tests.trend.stand_in import NEW, WEAR, SimulatedLoop, simulated_loop

HOURS = np.array([0.0, 500.0, 1000.0, 1500.0, 2000.0, 2500.0])
COLD_AND_HOT = (15.0, 35.0) * 3
MU = NAMES.index("mu")
REACHED = (HOURS / 3500.0) ** 0.8
CHANGE = -0.10
"""Of the logarithm of friction in 10 K."""


def drive(temperatures: Sequence[float | None]) -> list[SimulatedLoop]:
    """First loops of a drive that is cold and hot in turn, whatever is told of it."""
    rng = np.random.default_rng(4)
    tests = []
    for hours, worn, warm, told in zip(HOURS, REACHED, COLD_AND_HOT, temperatures, strict=False):
        friction = CHANGE * (warm - 25.0) / 10.0 * np.eye(8)[MU]
        mounted = NEW + WEAR * worn + friction + 0.008 * rng.standard_normal(8)
        tests.append(simulated_loop(float(hours), mounted, rng, temperature_C=told))
    return tests
