"""How far parameters and figures of merit were off while the model lacked an effect."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

from hdprog.explanation import Explanation, Quantiles
from hdprog.physics.parameters import FloatArray
from hdprog.results import DEVIATIONS_IN_90

_Number = TypeVar("_Number", float, FloatArray)


@dataclass(frozen=True)
class Shift:
    """A quantity without and with the effects.

    Attributes
    ----------
    key : name of a parameter, or key of a figure of merit
    is_figure : which of the two
    before, after : its quantiles
    deviations : change of the median in standard deviations of `before` (a 3.29th of its 90 %
        interval); None where that interval has no width
    """

    key: str
    is_figure: bool
    before: Quantiles
    after: Quantiles
    deviations: float | None

    @property
    def off_by(self) -> float | None:
        """How far the median was off without the effects, as a part of the one with them."""
        right = self.after[0.50]
        return None if right == 0 else (self.before[0.50] - right) / abs(right)


def deviation(levels: Mapping[float, _Number]) -> _Number:
    """Standard deviation as the 90 % interval of quantiles has it."""
    return (levels[0.95] - levels[0.05]) / DEVIATIONS_IN_90


def shifts(explanation: Explanation) -> list[Shift]:
    """Every parameter and figure that both fits have, the largest shift first."""
    found = [
        *_between(explanation.figures_before, explanation.figures_after, True),
        *_between(explanation.parameters_before, explanation.parameters_after, False),
    ]
    return sorted(found, key=lambda s: -abs(s.deviations or 0.0))


def _between(
    before: Mapping[str, Quantiles], after: Mapping[str, Quantiles], is_figure: bool
) -> list[Shift]:
    return [
        Shift(key, is_figure, before[key], after[key], _deviations(before[key], after[key]))
        for key in before
        if key in after
    ]


def _deviations(before: Quantiles, after: Quantiles) -> float | None:
    width = deviation(before)
    if not (math.isfinite(width) and width > 0):
        return None
    return (after[0.50] - before[0.50]) / width
