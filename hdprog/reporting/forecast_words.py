"""Hours of forecasts as pages say them: to the digits that their spread allows."""

from __future__ import annotations

import math
from collections.abc import Mapping

from hdprog.reporting.outlook import AT_ONCE
from hdprog.reporting.rounding import (
    about_middle,
    date_down,
    hours,
    hours_up,
    without_unit,
)

LATER = "past the horizon"


def spread(levels: Mapping[str, float | None], ahead: float | None = None) -> float:
    """Give the uncertainty in hours with which dates are rounded: half the 90 % interval.

    Parameters
    ----------
    levels : remaining hours
    ahead : hours from now to the horizon, which stand for a late end that is past it; without them
        such an interval is without end, and a date is rounded as far down as dates are
    """
    low, high = levels.get("q05"), levels.get("q95")
    late = ahead if high is None else high
    return math.inf if late is None else max((late - (low or 0.0)) / 2.0, 1.0)


def middle_words(levels: Mapping[str, float | None], start: float = 0.0) -> str:
    """Say the median, counted from `start`, to the digits that the nearer end of 90 % allows."""
    value = levels.get("q50")
    if value is None:
        return LATER
    return hours(start + value, about_middle(value, levels.get("q05"), levels.get("q95")))


def interval_words(
    levels: Mapping[str, float | None], start: float = 0.0, horizon: float | None = None
) -> str:
    """Say the 90 % interval: its early end rounded down, not to before `start`, its late end up.

    `horizon` is counted as `start` is; see `inspect_words`.
    """
    low, high = levels.get("q05"), levels.get("q95")
    if low is None:
        return LATER
    around = spread(levels, None if horizon is None else horizon - start)
    early = hours(date_down(start + low, start, around))
    if high is None:
        return f"{early} to {LATER}"
    return f"{without_unit(early)} to {hours_up(start + high, around)}"


def inspect_words(
    at: float | None,
    now: float,
    levels: Mapping[str, float | None],
    horizon: float | None = None,
    *,
    dated: bool = True,
) -> str:
    """Say by which service hour to inspect, in the words of the report, not to before now.

    `dated` as `outlook.dated` has it; one that is due now by what the drive is counts as dated.

    Where the late end lies past the horizon the report rounds by the horizon; without it, as of
    forecasts that earlier versions kept, the date is rounded as far down as dates are.
    """
    if at is None:
        return LATER
    if not dated:
        return "no date yet"
    if at <= now + AT_ONCE:
        return "now"
    return hours(date_down(at, now, spread(levels, None if horizon is None else horizon - now)))
