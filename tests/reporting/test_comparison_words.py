"""What a comparison says of a model, read off made-up numbers."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.comparison.results import StiffnessBand
from hdprog.reporting.comparison_words import at_end


def band(*torque: float) -> StiffnessBand:
    """Stiffness of 10 at the first torque, 30 at the last, give or take one."""
    middle = np.linspace(10.0, 30.0, len(torque))
    levels = {0.05: middle - 1.0, 0.25: middle, 0.5: middle, 0.75: middle, 0.95: middle + 1.0}
    return StiffnessBand(np.array(torque), levels)


@pytest.mark.parametrize(
    ("torque", "stiffness"),
    [((-50.0, 0.0, 50.0), 30.0), ((5.0, 50.0), 30.0), ((-50.0, -5.0), 10.0)],
)
def test_median_and_interval_are_of_the_same_torque(
    torque: tuple[float, ...], stiffness: float
) -> None:
    """Of a model that is not alike at both ends the median stood outside of its interval."""
    assert at_end(band(*torque)) == (stiffness - 1.0, stiffness, stiffness + 1.0)
