"""Levels at which everything that is drawn is reported."""

from __future__ import annotations

import numpy as np

from hdprog.physics.parameters import FloatArray

LEVELS: tuple[float, ...] = (0.05, 0.25, 0.50, 0.75, 0.95)
"""Quantile levels of every band and summary."""
DEVIATIONS_IN_90 = 3.29
"""Standard deviations between the 5 % and the 95 % point of a normal distribution."""


def by_level(draws: FloatArray) -> dict[float, float]:
    """Quantiles of draws (draws,) at `LEVELS`."""
    return dict(zip(LEVELS, np.quantile(draws, LEVELS).tolist(), strict=True))
