"""Hours of forecasts as pages say them: to the digits that their spread allows."""

from __future__ import annotations

import math
from collections.abc import Mapping

from hdprog.reporting.rounding import (
    about_middle,
    date_down,
    hours,
    hours_up,
    without_unit,
)

LATER = "past the horizon"


def spread(levels: Mapping[str, float | None]) -> float | None:
    """Give half the 90 % interval; None where an end is past the horizon."""
    low, high = levels.get("q05"), levels.get("q95")
    return None if low is None or high is None else (high - low) / 2.0


def middle_words(levels: Mapping[str, float | None], start: float = 0.0) -> str:
    """Say the median, counted from `start`, to the digits that the nearer end of 90 % allows."""
    value = levels.get("q50")
    if value is None:
        return LATER
    return hours(start + value, about_middle(value, levels.get("q05"), levels.get("q95")))


def interval_words(levels: Mapping[str, float | None], start: float = 0.0) -> str:
    """Say the 90 % interval: its early end rounded down, not to before `start`, its late end up."""
    low, high, around = levels.get("q05"), levels.get("q95"), spread(levels)
    if low is None:
        return LATER
    if high is None or around is None:
        return f"{hours(date_down(start + low, start, math.inf))} to {LATER}"
    early = without_unit(hours(date_down(start + low, start, around)))
    return f"{early} to {hours_up(start + high, around)}"


def inspect_words(
    at: float | None,
    now: float,
    levels: Mapping[str, float | None],
    horizon: float | None = None,
) -> str:
    """Say by which service hour to inspect, rounded down as in the report, not to before now.

    Where the late end lies past the horizon the report rounds by the horizon; without it, the date
    is rounded as far down as dates are.
    """
    if at is None:
        return LATER
    low, high = levels.get("q05"), levels.get("q95")
    late = high if high is not None or horizon is None else horizon - now
    if late is None:
        return hours(date_down(at, now, math.inf))
    return hours(date_down(at, now, max((late - (low or 0.0)) / 2.0, 1.0)))
