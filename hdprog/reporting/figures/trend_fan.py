"""Trend of one limited figure of merit: tests, fan, limit and crossing on one hour axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes

from hdprog.config import Limit
from hdprog.reporting import outlook
from hdprog.reporting.axes import THOUSANDS, Event, has_room, hour_axis, mark_events
from hdprog.reporting.crossing_density import crossing_density
from hdprog.reporting.figures.remaining_life import now_and_inspection
from hdprog.reporting.figures.trend_numbers import trend_numbers
from hdprog.reporting.rounding import hours, hours_up, percent
from hdprog.reporting.style import (
    BAND,
    FIT,
    INK,
    LIMIT,
    MEASURED,
    MUTED,
    Picture,
    new_figure,
    picture,
)
from hdprog.reporting.temperature_words import as_if_at
from hdprog.reporting.words import (
    capital,
    quantity,
    threshold_words,
    with_unit,
)
from hdprog.results import LEVELS, FigureTrend, Forecast, TestResult

_HILL = 0.16  # height of the density, as a part of the axis
_AHEAD = 4.0  # how many times as much as the time measured is shown of the time to come
_PAST_MIDDLE = 1.2  # and how much past the hour by which the limit is as likely passed as not


def trend_fan(
    trend: FigureTrend,
    forecast: Forecast,
    tests: Sequence[TestResult],
    *,
    doubtful: bool,
    dated: bool = True,
    due: bool = False,
) -> Picture:
    """Fan of a figure of merit over service hours with its limit and crossing interval.

    Parameters
    ----------
    trend : of the figure
    forecast : of a limit on it
    tests : for the events between them (regreased, reassembled, replaced)
    doubtful : the trend or a fit that it goes along did not converge
    dated : as in `remaining_life`
    due : the drive is to be inspected now, be it for another limit
    """
    limit = forecast.limit
    if limit is None:
        raise ValueError("a trend is drawn for one limit, not for the first of all")
    named = quantity(limit.key)
    measured, trend = trend, _converted(trend, named.factor)
    threshold = named.factor * limit.threshold
    figure = new_figure(7.6, 4.0)
    axes = figure.add_axes((0.115, 0.185, 0.855, 0.65))
    first, end = visible_hours(trend, forecast)
    hour_axis(axes, first, end)
    axes.set_ylim(*_range(trend, limit, threshold, end))
    axes.yaxis.set_major_formatter(THOUSANDS)
    axes.set_ylabel(named.head)
    mark_events(axes, _events(forecast, tests, dated=dated))
    _draw_fan(axes, trend)
    _draw_limit(axes, limit, threshold, forecast.now_hours)
    _draw_tests(axes, trend, tests)
    _draw_density(axes, forecast, limit, threshold, end)
    _draw_crossing(axes, forecast, threshold, end)
    axes.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.13), ncols=6, columnspacing=1.4)
    worse = "rises" if limit.direction == "above" else "falls"
    return picture(
        figure,
        alt=_alt(measured, forecast, limit),
        shows=(
            f"{capital(named.name)}: {named.meaning}. Points with bars are the tests, each by"
            f" itself{as_if_at(trend.reference_C)} (median, 90 %); the fan is the drive's state and"
            " its forecast without the scatter of remounting (dark 50 %, pale 90 %)."
            + _crossing_shown(forecast)
        ),
        good="the points scatter about the fan by about their own bars; the fan stays clear of"
        " the limit.",
        bad=f"the fan {worse} into the limit, or points lie outside it one after the other: wear"
        " has then changed its pace and the forecast is late in seeing it.",
        action=_action(forecast, dated=dated, due=due),
        data=trend_numbers(trend, forecast),
        doubtful=doubtful,
    )


def _crossing_shown(forecast: Forecast) -> str:
    """What stands on the limit line: nothing where the limit is passed."""
    if (
        forecast.already_crossed
        or not crossing_density(forecast, forecast.crossing_probability[:, 0]).any()
    ):
        return ""
    said = " The hill on the limit line is the density of the hour at which it is passed"
    crossing = outlook.crossing_hours(forecast)
    if crossing.get(0.05) is None:
        return f"{said}."
    whole = crossing.get(0.95) is not None
    bar = "spans 90 % of it (an arrow: it goes on)" if whole else "begins at 5 % of it and goes on"
    middle = "" if crossing.get(0.50) is None else ", the diamond is its middle"
    return f"{said}; the bar {bar}{middle}."


def _action(forecast: Forecast, *, dated: bool, due: bool) -> str:
    when = "now" if due else outlook.inspection(forecast, dated=dated)
    if not dated and when != "now":
        return "test again: only with a second test do points tell of a course."
    asked = {"now": "inspect now; ", "by a date": "test again before the inspection hour; "}
    return f"{asked.get(when, '')}where points leave the fan, test at half the interval."


def _converted(trend: FigureTrend, factor: float) -> FigureTrend:
    """Trend in the reader's unit."""
    return replace(
        trend,
        quantiles=factor * trend.quantiles,
        test_quantiles=factor * trend.test_quantiles,
    )


def visible_hours(trend: FigureTrend, forecast: Forecast) -> tuple[float, float]:
    """First and last hour shown: everything measured, and the crossing where there is one."""
    measured = trend.test_hours if trend.test_hours.size else np.array([forecast.now_hours])
    start = float(min(measured.min(), forecast.now_hours))
    late = outlook.crossing_hours(forecast).get(0.95)
    end = forecast.horizon_hours if late is None else late + 0.12 * (late - start)
    if forecast.already_crossed:
        end = forecast.now_hours + 0.35 * max(forecast.now_hours - start, 1.0)
    end = max(end, forecast.now_hours + 0.15 * max(forecast.now_hours - start, 1.0))
    end = min(end, _worth_showing(forecast, start))
    return start - 0.03 * (end - start), end


def _worth_showing(forecast: Forecast, start: float) -> float:
    """Hour after which a late end of the crossing would leave the tests no room."""
    middle = outlook.crossing_hours(forecast).get(0.50)
    measured = forecast.now_hours - start
    if middle is None or measured <= 0.0:
        return np.inf
    return max(forecast.now_hours + _AHEAD * measured, start + _PAST_MIDDLE * (middle - start))


def _range(trend: FigureTrend, limit: Limit, threshold: float, end: float) -> tuple[float, float]:
    """Range of values shown: tests, limit, and the fan as far as it says something.

    Far past the limit the fan may be cut off, so that the tests stay readable.
    """
    seen = trend.hours <= end
    values = [trend.quantiles[[0, -1]][:, seen].ravel(), trend.test_quantiles.ravel()]
    finite = np.concatenate(values)
    finite = np.append(finite[np.isfinite(finite)], threshold)
    tests = np.append(trend.test_quantiles.ravel(), threshold)
    span = max(float(np.ptp(tests)), 0.05 * abs(threshold))
    low = max(float(finite.min()), float(tests.min()) - 0.9 * span)
    high = min(float(finite.max()), float(tests.max()) + 0.9 * span)
    room = _HILL + 0.05  # past the limit, for the hill that stands on it
    if limit.direction == "above":
        high = max(high, threshold + room * (threshold - low))
    else:
        low = min(low, threshold - room * (high - threshold))
    margin = 0.07 * (high - low)
    bottom = low - margin
    return (max(bottom, 0.0) if low >= 0 else bottom), high + margin


def _draw_fan(axes: Axes, trend: FigureTrend) -> None:
    q05, q25, q50, q75, q95 = trend.quantiles
    axes.fill_between(
        trend.hours, q05, q95, color=BAND, alpha=0.16, linewidth=0, label="state, 90 %"
    )
    axes.fill_between(
        trend.hours, q25, q75, color=BAND, alpha=0.32, linewidth=0, label="state, 50 %"
    )
    axes.plot(trend.hours, q50, color=FIT, linewidth=1.8, label="state, median")


def _draw_limit(axes: Axes, limit: Limit, threshold: float, now: float) -> None:
    """Draw the limit and what is past it; its words stand before now or, without room, at the end.

    At the end they stand on the side that the hill of the crossing leaves free.
    """
    axes.axhline(threshold, color=LIMIT, linewidth=1.6)
    above = limit.direction == "above"
    low, high = axes.get_ylim()
    axes.axhspan(
        threshold if above else low,
        high if above else threshold,
        facecolor=LIMIT,
        alpha=0.06,
        linewidth=0,
        zorder=0,
    )
    text = f"limit {threshold_words(limit.key, limit.threshold)}"
    first, end = axes.get_xlim()
    at_end = not has_room(axes, text, first, now)
    upward = above != at_end
    axes.annotate(
        text,
        (end if at_end else first, threshold),
        xytext=(-4 if at_end else 4, 4 if upward else -4),
        textcoords="offset points",
        ha="right" if at_end else "left",
        va="bottom" if upward else "top",
        fontsize=8.5,
        color=LIMIT,
        zorder=5,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
    )


def _draw_tests(axes: Axes, trend: FigureTrend, tests: Sequence[TestResult]) -> None:
    middle = trend.test_quantiles[2]
    bars = np.abs(trend.test_quantiles[[0, -1]] - middle)
    axes.errorbar(
        trend.test_hours,
        middle,
        yerr=bars,
        fmt="o",
        color=MEASURED,
        markersize=4.5,
        capsize=2.5,
        linewidth=1.1,
        zorder=4,
        label="test by itself, 90 %",
    )
    marked = [number for number, test in enumerate(tests) if not test.converged]
    if marked:
        axes.plot(
            trend.test_hours[marked],
            middle[marked],
            "o",
            markersize=11,
            markerfacecolor="none",
            markeredgecolor=LIMIT,
            markeredgewidth=1.5,
            linestyle="none",
            zorder=5,
            label="not converged",
        )


def _draw_density(
    axes: Axes, forecast: Forecast, limit: Limit, threshold: float, end: float
) -> None:
    """Stand the density of the crossing on the limit line, on the side that is past it."""
    if forecast.already_crossed:
        return
    at = np.linspace(forecast.now_hours, end, 160)
    density = crossing_density(forecast, at)
    if not density.any():
        return
    low, high = axes.get_ylim()
    side = 1.0 if limit.direction == "above" else -1.0
    hill = threshold + side * _HILL * (high - low) * density / density.max()
    axes.fill_between(at, threshold, hill, color=INK, alpha=0.2, linewidth=0, zorder=3)
    axes.plot(at, hill, color=INK, linewidth=0.9, zorder=3)


def _draw_crossing(axes: Axes, forecast: Forecast, threshold: float, end: float) -> None:
    if forecast.already_crossed:
        return
    crossing = outlook.crossing_hours(forecast)
    early, middle, late = (crossing.get(level) for level in (0.05, 0.50, 0.95))
    if early is None:
        return
    if late is not None and late > end:
        late = None
    right = end if late is None else late
    axes.plot(
        [early, right],
        [threshold] * 2,
        color=INK,
        linewidth=3.2,
        zorder=5,
        solid_capstyle="butt",
    )
    ends = [early] if late is None else [early, late]
    axes.plot(
        ends,
        [threshold] * len(ends),
        "|",
        color=INK,
        markersize=11,
        markeredgewidth=2.0,
        zorder=5,
    )
    if late is None:
        axes.plot([end], [threshold], ">", color=INK, markersize=7, zorder=6, clip_on=False)
    if middle is not None and middle <= end:
        axes.plot(
            [middle],
            [threshold],
            "D",
            color="white",
            markeredgecolor=INK,
            markersize=5.5,
            zorder=6,
        )


def _events(forecast: Forecast, tests: Sequence[TestResult], *, dated: bool) -> list[Event]:
    return now_and_inspection(forecast, dated=dated) + [
        Event(test.service_hours, test.event, MUTED, ":")
        for test in tests
        if test.event and test.service_hours is not None
    ]


def _alt(trend: FigureTrend, forecast: Forecast, limit: Limit) -> str:
    named = quantity(limit.key)
    low, middle, high = outlook.figure_now(trend, forecast)
    text = (
        f"{capital(named.name)} is {with_unit(middle, named.unit)} now (90 %: {low} to {high}); "
        f"the limit is {threshold_words(limit.key, limit.threshold)}. "
    )
    crossing, spread = outlook.crossing_hours(forecast), outlook.spread(forecast)
    early, late = crossing.get(0.05), crossing.get(0.95)
    risk = percent(outlook.risk_now(forecast))
    if forecast.already_crossed:
        return text + f"It is passed already with a probability of {risk}."
    if early is None:
        stays = percent(1.0 - forecast.probability_crossed_by_horizon)
        return text + f"It is not passed before {hours(forecast.horizon_hours)} ({stays})."
    if outlook.risk_now(forecast) >= 1.0 - LEVELS[-1]:
        by = forecast.horizon_hours if late is None else late
        chance = percent(forecast.probability_crossed_by_horizon) if late is None else "95 %"
        end = hours(by) if late is None else hours_up(by, spread)
        return text + f"It is passed by {end} ({chance}), already with a probability of {risk}."
    until = (
        f"a time later than {hours(forecast.horizon_hours)}"
        if late is None
        else hours_up(late, spread)
    )
    return (
        text
        + f"It is passed between {hours(outlook.rounded_date(forecast, early))} and {until} (90 %)."
    )
