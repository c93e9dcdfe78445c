"""Remaining life: density and distribution of the first crossing over service hours."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from hdprog.reporting import outlook
from hdprog.reporting.axes import PERCENT, Event, hour_axis, mark_events
from hdprog.reporting.crossing_density import crossing_density
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.rounding import (
    THIN_SPACE,
    hours,
    hours_up,
    percent,
    percent_beside,
    share,
)
from hdprog.reporting.style import (
    FIT,
    INK,
    INSPECT,
    LIMIT,
    MUTED,
    SHUTDOWN,
    Picture,
    new_figure,
    picture,
)
from hdprog.reporting.words import capital, listed
from hdprog.results import Forecast

_COMMON = 0.1  # probability of passing by the horizon, below which the hill is drawn lower
_WORTH_SAYING = 0.05  # of what lies outside of the picture
_ROOM_FOR_WORDS = 0.25  # of the height of the hill's axes
_WIDTH_OF_WORDS = 0.07  # "50 %", of the width of the hill's axes
_LINE = 0.13  # of words, of their height
_LEGEND_COLUMNS = 2
_LEGEND_ROW = 0.207  # inches
_LEGEND_GAP = 0.02  # inches below the last row
_DASHES = ((0, (6, 2)), (0, (1.5, 1.5)), (0, (6, 2, 1.5, 2)), (0, (3, 1)))


def remaining_life(
    forecasts: Sequence[Forecast],
    shutdown_hours: float | None,
    *,
    doubtful: bool,
    passed: Sequence[Forecast] = (),
    dated: bool = True,
) -> Picture:
    """Density of the first crossing, and below it its probability up to each hour.

    Parameters
    ----------
    forecasts : of one drive, at least one
    shutdown_hours : service hours of the next shutdown, or None
    doubtful : a fit or the trend behind them did not converge
    passed : forecasts of limits that are passed already, which are told and not drawn
    dated : whether a date to inspect before is told, see `outlook.dated`
    """
    main = outlook.overall(forecasts)
    if main is None:
        raise ValueError("remaining life needs a forecast")
    single = outlook.limited(forecasts)
    legend = _legend_height(single)
    height = 5.0 + legend
    figure = new_figure(7.6, height)
    axes = figure.add_axes((0.09, (0.52 + legend) / height, 0.88, 2.3 / height))
    hill = figure.add_axes((0.09, (2.98 + legend) / height, 0.88, 1.2 / height))
    end = _view_end(main, shutdown_hours)
    first = main.now_hours - 0.02 * (end - main.now_hours)
    hour_axis(axes, first, end)
    hour_axis(hill, first, end)
    _draw_density(hill, main, end)
    axes.set_ylim(0.0, 1.0)
    axes.yaxis.set_major_formatter(PERCENT)
    axes.set_ylabel("probability of having passed")
    events = _events(main, shutdown_hours, dated=dated and not passed)
    mark_events(hill, events)
    for event in events:
        if first <= event.hours <= end:
            axes.axvline(event.hours, color=event.colour, linestyle=event.line, linewidth=1.2)
    _draw_curves(axes, main, single)
    _draw_risk(axes, main, end)
    _mark_levels(axes, main, end)
    others = "single" if main.limit is None else "other"
    return picture(
        figure,
        alt=_alt(main, shutdown_hours, passed, dated=dated and not passed),
        shows=(
            "Above: where the hour of passing "
            + ("the first of the limits" if main.limit is None else "the limit")
            + f" lies, if nothing is done{_read_so(main, end)}. Below: the probability that it has"
            " been passed by a service hour; points mark the same levels."
            + (f" Broken lines are the {others} limits." if len(single) > 1 else "")
        ),
        good="the line stays below the accepted risk until well past the next shutdown.",
        bad="it is above the accepted risk at the next shutdown, or starts above it at now.",
        action=_action(main, dated=dated, passed=bool(passed))
        + " A line that rises slowly over many hours is a date hardly known: another test narrows"
        " it.",
        data=_data(main, single),
        doubtful=doubtful,
    )


def _legend_height(single: Sequence[Forecast]) -> float:
    """Inches that the legend takes up; none where a single limit needs no name."""
    if len(single) < 2:
        return 0.0
    rows = math.ceil((1 + len(single)) / _LEGEND_COLUMNS)
    return _LEGEND_GAP + rows * _LEGEND_ROW


def _action(main: Forecast, *, dated: bool, passed: bool) -> str:
    when = outlook.inspection(main, dated=dated)
    if passed or when == "now":
        return "inspect now."
    if when == "no date yet":
        return "test again."
    accepted = share(main.acceptable_risk)
    return f"inspect before the line reaches the accepted risk of {accepted}."


def _marked(main: Forecast, end: float) -> dict[float, float]:
    """Levels that are reached after now and in the picture, each with its hour."""
    crossing = outlook.crossing_hours(main)
    found = {level: crossing.get(level) for level in (0.05, 0.50, 0.95)}
    return {
        level: hour
        for level, hour in found.items()
        if hour is not None and hour <= end and level > outlook.risk_now(main)
    }


def _read_so(main: Forecast, end: float) -> str:
    """Say what the darker part of the hill is, and its marks, as far as they are drawn."""
    crossing, marks = outlook.crossing_hours(main), _marked(main, end)
    parts = []
    if crossing.get(0.05) is not None:
        whole = crossing.get(0.95) is not None and outlook.risk_now(main) <= _WORTH_SAYING
        parts.append("the darker part " + ("holds 90 %" if whole else "lies past 5 %"))
    if marks:
        told = listed(f"{100 * level:.0f}" for level in marks)
        parts.append(f"the {'mark is' if len(marks) == 1 else 'marks are'} {told} %")
    return f"; {', '.join(parts)}" if parts else ""


def _draw_density(axes: Axes, main: Forecast, end: float) -> None:
    """Draw the hill of the hours, its middle 90 % darker, and what lies outside in words."""
    at = np.linspace(main.now_hours, end, 240)
    density = crossing_density(main, at)
    axes.set_yticks([])
    axes.set_ylabel("density")
    axes.spines["left"].set_visible(False)
    axes.tick_params(labelbottom=False)
    axes.set_xlabel("")
    crossing = outlook.crossing_hours(main)
    early, late = crossing.get(0.05), crossing.get(0.95)
    axes.fill_between(at, density, color=FIT, alpha=0.18, linewidth=0)
    if early is not None:
        inner = (at >= early) & (at <= (end if late is None else late))
        axes.fill_between(at[inner], density[inner], color=FIT, alpha=0.35, linewidth=0)
    axes.plot(at, density, color=FIT, linewidth=1.6)
    # What hardly ever happens makes no mountain.
    rare = min(float(main.crossing_probability[-1, 1]) / _COMMON, 1.0)
    top = 1.3 * float(density.max()) / max(rare, 1e-3) or 1.0
    axes.set_ylim(0.0, top)
    before, base = -np.inf, 0.0
    for level, hour in _marked(main, end).items():
        height = float(np.interp(hour, at, density))
        axes.plot([hour, hour], [0.0, height], color=INK, linewidth=1.3)
        inside = height > _ROOM_FOR_WORDS * top  # under the curve, which they would hide
        # Words that would run into those of the level before stand above them.
        beside = hour - before < _WIDTH_OF_WORDS * (end - main.now_hours)
        base = base + _LINE * top if beside else 0.0 if inside else height
        before = hour
        axes.annotate(
            share(level),
            (hour, base),
            xytext=(4, 4),
            textcoords="offset points",
            fontsize=8.5,
            color=INK,
            zorder=5,
        )
    already = outlook.risk_now(main)
    if already > _WORTH_SAYING:
        axes.text(
            0.028,
            0.92,
            f"passed already: {percent(already)}",
            transform=axes.transAxes,
            va="top",
            fontsize=8.5,
            color=INK,
        )
    later = 1.0 - main.probability_crossed_by_horizon
    if later > _WORTH_SAYING:
        axes.text(
            0.995,
            0.92,
            f"later than {hours(main.horizon_hours)}: {percent(later)}",
            transform=axes.transAxes,
            ha="right",
            va="top",
            fontsize=8.5,
            color=INK,
        )


def _data(main: Forecast, single: Sequence[Forecast]) -> PictureData:
    """Density and probability of the first crossing, and the probability of each limit."""
    table = main.crossing_probability
    columns = ["service hours", "density [1/h]", "probability of having passed"]
    values = [table[:, 0], crossing_density(main, table[:, 0]), table[:, 1]]
    if len(single) > 1:
        for forecast in single:
            if forecast.limit is not None:
                columns.append(outlook.limit_words(forecast.limit).replace(THIN_SPACE, " "))
                own = forecast.crossing_probability
                values.append(np.interp(table[:, 0], own[:, 0], own[:, 1]))
    return PictureData.along("remaining-life", columns, *values)


def _view_end(main: Forecast, shutdown_hours: float | None) -> float:
    late = outlook.crossing_hours(main).get(0.95)
    if late is None:
        return main.horizon_hours
    end = main.now_hours + 1.15 * max(late - main.now_hours, 1.0)
    if shutdown_hours is not None and shutdown_hours < main.horizon_hours:
        end = max(end, main.now_hours + 1.08 * (shutdown_hours - main.now_hours))
    return min(end, max(main.horizon_hours, late))


def _draw_curves(axes: Axes, main: Forecast, single: Sequence[Forecast]) -> None:
    table = main.crossing_probability
    axes.fill_between(table[:, 0], table[:, 1], color=FIT, alpha=0.12, linewidth=0)
    (line,) = axes.plot(table[:, 0], table[:, 1], color=FIT, linewidth=2.4, zorder=3)
    if len(single) < 2:
        return
    first = main.limit
    handles = [line]
    labels = ["first of all limits" if first is None else outlook.limit_words(first)]
    for forecast, dash in zip(single, _DASHES * len(single), strict=False):
        if forecast.limit is None or forecast is main:
            continue
        own = forecast.crossing_probability
        handles += axes.plot(own[:, 0], own[:, 1], color=MUTED, linestyle=dash, linewidth=1.4)
        labels.append(outlook.limit_words(forecast.limit))
    axes.legend(
        handles,
        labels,
        loc="upper left",
        bbox_to_anchor=(-0.02, -0.2),
        ncols=_LEGEND_COLUMNS,
        handlelength=3.2,
    )


def _mark_levels(axes: Axes, main: Forecast, end: float) -> None:
    spread = outlook.spread(main)
    for level, at in _marked(main, end).items():
        axes.plot([at], [level], "o", color=FIT, markersize=6, markeredgecolor="white", zorder=4)
        if level < 0.1:
            text = hours(outlook.rounded_date(main, at))
        elif level > 0.9:
            text = hours_up(at, spread)
        else:
            text = hours(at, outlook.spread_about_median(main))
        # The curve leaves the upper left of each point free, save at the very left.
        left = at - main.now_hours > 0.2 * (end - main.now_hours)
        axes.annotate(
            f"{share(level)}: {text}",
            (at, level),
            xytext=(-7, 3) if left else (8, -3),
            textcoords="offset points",
            ha="right" if left else "left",
            fontsize=8.5,
            color=INK,
            zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
        )


def _draw_risk(axes: Axes, main: Forecast, end: float) -> None:
    axes.axhline(main.acceptable_risk, color=LIMIT, linestyle=(0, (5, 2)), linewidth=1.2)
    axes.annotate(
        f"accepted risk {share(main.acceptable_risk)}",
        (end, main.acceptable_risk),
        xytext=(-2, 3),
        textcoords="offset points",
        ha="right",
        fontsize=8.5,
        color=LIMIT,
        zorder=5,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
    )


def now_and_inspection(forecast: Forecast, *, dated: bool) -> list[Event]:
    """Marks of now and of the date to inspect before, of that only where it is told."""
    events = [Event(forecast.now_hours, "now", INK, "-")]
    inspect = outlook.inspection_hours(forecast)
    if inspect is not None and outlook.inspection(forecast, dated=dated) == "by a date":
        events.append(Event(inspect, f"inspect before {hours(inspect)}", INSPECT, "-"))
    return events


def _events(main: Forecast, shutdown_hours: float | None, *, dated: bool) -> list[Event]:
    events = now_and_inspection(main, dated=dated)
    if shutdown_hours is not None:
        text = f"next shutdown {hours(shutdown_hours)}"
        risk = main.probability_crossed_by_shutdown
        if risk is not None:
            text += f": {percent_beside(risk, main.acceptable_risk)}"
        events.append(Event(shutdown_hours, text, SHUTDOWN, "--"))
    return events


def _alt(
    main: Forecast, shutdown_hours: float | None, passed: Sequence[Forecast], *, dated: bool
) -> str:
    what = "the first limit" if main.limit is None else outlook.limit_words(main.limit)
    parts = []
    if shutdown_hours is not None and main.probability_crossed_by_shutdown is not None:
        risk = percent_beside(main.probability_crossed_by_shutdown, main.acceptable_risk)
        parts.append(f"risk {risk} by the next shutdown at {hours(shutdown_hours)}")
    inspect = outlook.inspection_hours(main)
    if main.already_crossed:
        parts.append(f"passed already with a probability of {percent(outlook.risk_now(main))}")
    elif inspect is not None and (when := outlook.inspection(main, dated=dated)) != "no date yet":
        reached = f"not reached before {hours(inspect)}"  # which is rounded down
        if when == "now":
            over = outlook.risk_now(main) >= main.acceptable_risk
            reached = "reached already" if over else "reached within two hours"
        parts.append(f"accepted risk of {share(main.acceptable_risk)} {reached}")
    median = outlook.crossing_hours(main).get(0.50)
    if median is not None and not main.already_crossed:
        parts.append(f"even odds at {hours(median, outlook.spread_about_median(main))}")
    chance = percent(main.probability_crossed_by_horizon)
    parts.append(f"{chance} by {hours(main.horizon_hours)}")
    told = f"{capital(what)}: {'; '.join(parts)}."
    if not passed:
        return told
    those = listed(outlook.limit_words(one.limit) for one in passed if one.limit is not None)
    are = "is" if len(passed) == 1 else "are"
    how = "passed already" if all(map(outlook.surely_passed, passed)) else "likely passed already"
    return f"{told} {capital(those)} {are} {how}, and not in this picture."
