"""Where a drive stands against its limits: read off the forecasts, nothing added to them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from hdprog.config import Limit
from hdprog.reporting.rounding import about_middle, date_down, hours
from hdprog.reporting.words import figure_interval, quantity, threshold_words
from hdprog.results import LEVELS, DriveResult, FigureTrend, Forecast, since_replaced

AT_ONCE = 2.0  # service hours ahead that no plan tells from now
NOW = "now"
Inspection = Literal["now", "by a date", "not due", "no date yet"]

_FAR_TAIL = 0.1  # of the middle of remaining life
_SHORT_WAIT = 0.1  # of the longest time between two tests so far
_WAITING = 6  # service hours, about, that a risk is stated at
_SURE = 0.95  # probability from which a limit is said to be passed


def limit_words(limit: Limit) -> str:
    """Limit in words: "lost motion above 2 arcmin"."""
    named = quantity(limit.key)
    return f"{named.name} {limit.direction} {threshold_words(limit.key, limit.threshold)}"


def passing_words(limit: Limit) -> str:
    """Say what passing the limit is: "pass 2 arcmin" or "fall below 12 000 Nm/rad"."""
    verb = "pass" if limit.direction == "above" else "fall below"
    return f"{verb} {threshold_words(limit.key, limit.threshold)}"


def limited(forecasts: Sequence[Forecast]) -> tuple[Forecast, ...]:
    """Forecasts of single limits, without the first of them all."""
    return tuple(forecast for forecast in forecasts if forecast.limit is not None)


def not_passed(forecasts: Sequence[Forecast]) -> tuple[Forecast, ...]:
    """Forecasts of what is still to come, the first of all limits beside single ones that are.

    Several limits can be more likely passed than not while none of them is by itself: what is left
    of the single ones would then tell of later hours than those that count.
    """
    if not passed(forecasts):
        return tuple(forecasts)
    return tuple(forecast for forecast in forecasts if not forecast.already_crossed)


def passed(forecasts: Sequence[Forecast]) -> tuple[Forecast, ...]:
    """Forecasts of single limits that are more likely passed than not."""
    return tuple(forecast for forecast in limited(forecasts) if forecast.already_crossed)


def overall(forecasts: Sequence[Forecast]) -> Forecast | None:
    """Find the forecast of the first of all limits, else the leading one; None without any."""
    for forecast in forecasts:
        if forecast.limit is None:
            return forecast
    return leading(forecasts)


def leading(forecasts: Sequence[Forecast]) -> Forecast | None:
    """Find the single limit that is most likely the first to be passed, None without any.

    The limit already passed, else the one with the earliest median, else with the highest
    probability at the horizon.
    """

    def order(forecast: Forecast) -> tuple[bool, float, float]:
        median = forecast.remaining_hours.get(0.50)
        return (
            not forecast.already_crossed,
            math.inf if median is None else median,
            -forecast.probability_crossed_by_horizon,
        )

    return min(limited(forecasts), key=order, default=None)


def deciding(forecasts: Sequence[Forecast]) -> Forecast | None:
    """Find the single limit that sets the date to inspect before: the leading one.

    Unless that carries little of the risk by then: a limit that is likely passed later may, with a
    wider spread, set the date.
    """
    main, first = overall(forecasts), leading(forecasts)
    if main is None or first is None or main.inspect_before_hours is None:
        return first
    at = main.inspect_before_hours
    most = max(limited(forecasts), key=lambda one: risk_at(one, at))
    return first if risk_at(first, at) >= 0.5 * risk_at(most, at) else most


def risk_at(forecast: Forecast, hours: float) -> float:
    """Probability that the limit is passed by a service hour between now and the horizon."""
    table = forecast.crossing_probability
    return float(np.interp(hours, table[:, 0], table[:, 1]))


def risk_now(forecast: Forecast) -> float:
    """Probability that the limit is passed already."""
    return float(forecast.crossing_probability[0, 1])


def crossing_hours(forecast: Forecast) -> dict[float, float | None]:
    """Service hours of the crossing by level; None past the horizon."""
    return {
        level: None if value is None else forecast.now_hours + value
        for level, value in forecast.remaining_hours.items()
    }


def spread(forecast: Forecast) -> float:
    """Uncertainty in hours with which crossing hours are rounded: half the 90 % interval.

    Where its late end is past the horizon, the horizon stands for it.
    """
    hours = crossing_hours(forecast)
    late, early = hours.get(LEVELS[-1]), hours.get(LEVELS[0])
    end = forecast.horizon_hours if late is None else late
    start = forecast.now_hours if early is None else early
    return max((end - start) / 2.0, 1.0)


def spread_about_median(forecast: Forecast) -> float:
    """Uncertainty in hours with which a median is rounded: the way to the nearer end of 90 %."""
    hours = crossing_hours(forecast)
    median, about = hours.get(0.50), None
    if median is not None:
        about = about_middle(median, hours.get(LEVELS[0]), hours.get(LEVELS[-1]))
    return spread(forecast) if about is None else max(about, 1.0)


def due_now(forecast: Forecast) -> bool:
    """Whether the accepted risk is reached already, or within two hours, or the limit is passed.

    What is more likely passed than not is to be inspected now, whatever risk is accepted.
    """
    return (
        forecast.inspect_before_hours is not None
        and forecast.inspect_before_hours <= forecast.now_hours + AT_ONCE
    )


def next_test_hours(result: DriveResult) -> float | None:
    """When the next test is due at the latest: half-way from now to the inspection.

    Where that has no date, the hour by which a limit is passed with a chance of one in four: only
    the tail of a prior tells of earlier ones, and another test cuts it off. Without either
    before the horizon: after as long again as the longest time between two tests so far, and where
    that is no time, half-way to the horizon. None where the inspection is due now, or nothing was
    forecast.
    """
    forecast = overall(result.forecasts)
    if forecast is None or inspect_now(result, forecast):
        return None
    now = forecast.now_hours
    if not dated(result):
        quarter = forecast.remaining_hours.get(0.25)
        if quarter is not None:
            return now + quarter
    elif forecast.inspect_before_hours is not None:
        return now + (forecast.inspect_before_hours - now) / 2.0
    longest = _longest_interval(result)
    if longest > AT_ONCE:
        return min(now + longest, forecast.horizon_hours)
    return now + (forecast.horizon_hours - now) / 2.0


def next_test_words(result: DriveResult, at: float) -> str:
    """Say by when to test again, or `NOW`.

    A wait that is short beside those between the tests so far is none: a test now, the drive
    mounted anew, tells as much of it.

    Parameters
    ----------
    at : as `next_test_hours` has it
    """
    main = overall(result.forecasts)
    if main is None:
        raise ValueError("nothing was forecast")
    if dated(result) and at - main.now_hours <= _SHORT_WAIT * _longest_interval(result):
        return NOW
    return f"by {hours(rounded_date(main, at))}"


def _longest_interval(result: DriveResult) -> float:
    """Longest time in h between two tests so far."""
    tested = sorted(t.service_hours for t in result.tests if t.service_hours is not None)
    return float(np.diff(tested).max(initial=0.0))


def tested_at(result: DriveResult) -> int:
    """How many service hours there are tests of: only different ones tell of a pace."""
    return len({test.service_hours for test in since_replaced(result.tests)})


def dated(result: DriveResult) -> bool:
    """Whether a date to inspect before is told: not where it is but the far tail of a prior.

    That of any drive, told after one test, has five in a hundred worn within hours; that of a
    fleet, or of a drive far from its limits, tells a date all the same.
    """
    main = overall(result.forecasts)
    if main is None or tested_at(result) > 1 or main.already_crossed:
        return True
    at, median = main.inspect_before_hours, main.remaining_hours[0.50]
    if at is None:
        return True
    return median is not None and at - main.now_hours >= _FAR_TAIL * median


def figure_now(trend: FigureTrend, forecast: Forecast) -> tuple[str, str, str]:
    """Low end, median and high end of a figure at the forecast's now (90 %), in words."""
    now = [float(np.interp(forecast.now_hours, trend.hours, q)) for q in trend.quantiles[[0, 2, 4]]]
    return figure_interval(trend.key, *now)


def surely_passed(forecast: Forecast) -> bool:
    """Whether a limit is passed without further words."""
    return risk_now(forecast) >= _SURE


def inspect_now(result: DriveResult, forecast: Forecast) -> bool:
    """Whether an inspection is due now; by what the drive is, where no date is told."""
    return inspection(forecast, dated=dated(result)) == "now"


def inspection(forecast: Forecast, *, dated: bool) -> Inspection:
    """When to inspect for a limit, in kind; the same in words, tables and pictures.

    `dated` as `outlook.dated` says: without a date to tell, what is due now is so by what the drive
    is, not by what a prior thinks may come within hours.
    """
    now = due_now(forecast) if dated else risk_now(forecast) >= forecast.acceptable_risk
    if now:
        return "now"
    if forecast.inspect_before_hours is None:
        return "not due"
    return "by a date" if dated else "no date yet"


def waiting_hours(forecast: Forecast) -> list[float]:
    """Round service hours at which to state the risk, from now to where little is left to learn.

    They end where the probability has all but reached its last value, or at the horizon.
    """
    table = forecast.crossing_probability
    start, top = float(table[0, 1]), float(table[-1, 1])
    to_come = top - start
    reached = np.searchsorted(table[:, 1], min(0.95, start + 0.98 * to_come))
    end = forecast.horizon_hours if to_come <= 0.02 else float(table[reached, 0])
    span = max(end - forecast.now_hours, 1.0)
    power = 10.0 ** math.floor(math.log10(span / _WAITING))
    step = next(f * power for f in (1.0, 2.0, 2.5, 5.0, 10.0) if span / (f * power) <= _WAITING)
    first = math.floor(forecast.now_hours / step + 1.0) * step
    hours = [first + step * i for i in range(_WAITING + 1)]
    return [value for value in hours if value <= min(end + step, forecast.horizon_hours)]


def deciding_risks(result: DriveResult) -> list[tuple[float, float]]:
    """Service hours and the risk by then: round ones, the shutdown and what is due.

    That is the inspection, and the next test where there is no date of one yet. The round ones
    alone can all lie past the hour at which something has to be done.
    """
    main, ahead = overall(result.forecasts), shutdown_ahead(result)
    if main is None:
        return []
    told = inspection(main, dated=dated(result)) == "by a date"
    due = inspection_hours(main) if told else None
    test = None if told else next_test_hours(result)
    stated = {at: risk_at(main, at) for at in waiting_hours(main)}
    if due is not None:
        stated[due] = min(risk_at(main, due), main.acceptable_risk)
    if test is not None:
        test = rounded_date(main, test)
        stated[test] = risk_at(main, test)
    if ahead is not None and ahead[0] <= main.horizon_hours:
        stated[ahead[0]] = ahead[1]
    return sorted(stated.items())


def shutdown_ahead(result: DriveResult) -> tuple[float, float] | None:
    """Service hours of the next shutdown and the risk by then; None if none lies ahead."""
    main, at = overall(result.forecasts), result.drive.forecast.next_shutdown_hours
    if main is None or at is None or at <= main.now_hours:
        return None
    risk = main.probability_crossed_by_shutdown
    return None if risk is None else (at, risk)


def inspection_hours(forecast: Forecast) -> float | None:
    """Service hours to inspect before, rounded down but not to before now; None if not due."""
    at = forecast.inspect_before_hours
    return None if at is None else rounded_date(forecast, at)


def rounded_date(forecast: Forecast, at: float) -> float:
    """Date rounded down by its uncertainty, at most by a small part of the wait for it."""
    return date_down(at, forecast.now_hours, spread(forecast))
