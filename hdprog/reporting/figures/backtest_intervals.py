"""Forecasts of each limit from one test after another, against what came later."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from hdprog.config import Limit
from hdprog.forecast.backtest import CrossingScore, OriginScores
from hdprog.forecast.backtest_pool import DriveScores
from hdprog.reporting.axes import hour_axis
from hdprog.reporting.outlook import limit_words
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.rounding import THIN_SPACE, hours
from hdprog.reporting.style import FIT, INK, LIMIT, Picture, new_figure, picture
from hdprog.reporting.words import agree, capital, counted, listed
from hdprog.results import LEVELS

Row = tuple[OriginScores, CrossingScore]
_ROW = 0.25  # inches
_ABOVE, _BELOW, _TOP = 0.42, 0.62, 0.42
_BETWEEN = "by less than the tests tell"
_LISTED = 2  # crossings of one limit that a title names
_FARTHER = 2.2  # of the way from the first test to the last that came, which the axis shows


def forecast_intervals(drive: DriveScores) -> Picture | None:
    """Intervals of every origin, a panel a limit; None without forecasts."""
    limits = list(dict.fromkeys(score.limit for score in drive.crossings))
    panels = [(limit, _rows(drive, limit)) for limit in limits]
    if not panels:
        return None
    sizes = [_ROW * len(rows) + _ABOVE + _BELOW for _, rows in panels]
    height = sum(sizes) + _TOP
    figure = new_figure(7.6, height)
    figure.legend(
        handles=_legend(drive),
        loc="upper left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=5,
        handlelength=1.8,
    )
    top = height - _TOP
    span = _span(drive)
    for (limit, rows), size in zip(panels, sizes, strict=True):
        place = (0.16, (top - size + _BELOW) / height, 0.72, (size - _ABOVE - _BELOW) / height)
        _panel(figure.add_axes(place), limit, rows, span)
        top -= size
    return picture(
        figure,
        alt=_alt(drive),
        shows=(
            "One row for each test that a forecast was made from: the thin bar is the 90 %"
            " interval of the crossing, the thick bar the 50 % interval, the point the even odds;"
            " an arrow goes on beyond the axis. What came later is drawn across: a line where the"
            " limit was passed, a triangle up to where it was not."
        ),
        good="the line runs through nearly all thin bars, and they shorten from row to row.",
        bad="bars lie beside the line, all on the same side, or shorten away from it.",
        action=(
            "where later rows miss on one side, look at that limit's trend in the report of"
            " `hdprog run`: a break or an effect there was not known to the forecasts."
        ),
        data=_data(drive),
    )


def _rows(drive: DriveScores, limit: Limit) -> list[Row]:
    return [
        (origin, score)
        for origin in drive.origins
        for score in origin.crossings
        if score.limit == limit
    ]


def _data(drive: DriveScores) -> PictureData:
    """Every forecast and what came; a quantile past the horizon is empty, as is no crossing."""
    named = (f"forecast, {100 * level:.0f} % [h]" for level in LEVELS)
    rows = [
        (
            limit_words(score.limit).replace(THIN_SPACE, " "),
            origin.test_id,
            origin.service_hours,
            *(score.quantiles[level] for level in LEVELS),
            score.crossed_at if score.crossing_seen else None,
            score.seen_until,
        )
        for origin in drive.origins
        for score in origin.crossings
    ]
    columns = ("limit", "test", "forecast at [h]", *named, "passed at [h]", "seen until [h]")
    return PictureData.of(f"forecasts-{drive.name}", columns, rows)


def _span(drive: DriveScores) -> tuple[float, float]:
    """Hours that the axes show: what came, and a good deal beyond."""
    first = drive.origins[0].service_hours
    seen = [score.crossed_at for score in drive.crossings if score.crossing_seen]
    last = max(seen or [max(score.seen_until for score in drive.crossings)])
    last = max(last, drive.origins[-1].service_hours)
    ends = [q for score in drive.crossings if (q := score.quantiles[0.95]) is not None]
    wide = min(first + _FARTHER * (last - first), drive.horizon_hours)
    return first, min(wide, 1.05 * max([last, *ends])) if ends else wide


def _panel(axes: Axes, limit: Limit, rows: Sequence[Row], span: tuple[float, float]) -> None:
    first, last = span
    hour_axis(axes, first - 0.01 * (last - first), last)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    axes.set_title(capital(limit_words(limit)) + _passed(rows))
    axes.set_yticks(range(len(rows)), [_label(origin) for origin, _ in rows])
    for at, (origin, score) in enumerate(rows):
        _bar(axes, at, score, last)
        axes.plot(origin.service_hours, at, "|", color=INK, markersize=8, markeredgewidth=1.4)
        if not score.held[0.9]:
            axes.annotate(
                "missed",
                (1.0, at),
                xycoords=axes.get_yaxis_transform(),
                xytext=(8, 0),
                textcoords="offset points",
                va="center",
                color=LIMIT,
                fontsize=8.5,
                fontweight="bold",
            )
    _what_came(axes, rows)


def _passed(rows: Sequence[Row]) -> str:
    last = rows[-1][1]
    seen = dict.fromkeys(score.crossed_at for _, score in rows if score.crossing_seen)
    if not seen:
        return f": not passed by {hours(last.seen_until)}"
    if len(seen) > _LISTED:
        passed = f": passed {len(seen)} times, last at {hours(max(seen))}"
    else:
        passed = f": passed at {listed(map(hours, seen))}"
    return passed if last.crossing_seen else f"{passed}, not again by {hours(last.seen_until)}"


def _label(origin: OriginScores) -> str:
    mark = "" if origin.converged else "*"
    # Two dollar signs in a name would be taken for a formula.
    return f"{origin.test_id}{mark}, {hours(origin.service_hours)}".replace("$", r"\$")


def _bar(axes: Axes, at: int, score: CrossingScore, last: float) -> None:
    colour = FIT if score.held[0.9] else LIMIT
    for low, high, width in ((0.05, 0.95, 1.6), (0.25, 0.75, 5.0)):
        start, end = score.quantiles[low], score.quantiles[high]
        start, end = (last if edge is None else min(edge, last) for edge in (start, end))
        if start < end:
            axes.plot(
                [start, end],
                [at, at],
                color=colour,
                linewidth=width,
                alpha=0.65,
                solid_capstyle="butt",
            )
    end, middle = score.quantiles[0.95], score.quantiles[0.5]
    if end is None or end > last:
        axes.plot(
            1.0,
            at,
            ">",
            color=colour,
            markersize=5,
            clip_on=False,
            transform=axes.get_yaxis_transform(),
        )
    if middle is not None and middle <= last:
        axes.plot(middle, at, "o", color=colour, markersize=5, markeredgecolor="white", zorder=4)


def _what_came(axes: Axes, rows: Sequence[Row]) -> None:
    seen = [(at, score.crossed_at) for at, (_, score) in enumerate(rows) if score.crossing_seen]
    for at, crossed in seen:
        axes.plot([crossed, crossed], [at - 0.5, at + 0.5], color=INK, linewidth=1.6, zorder=5)
    for at, (_, score) in enumerate(rows):
        if not score.crossing_seen:
            axes.plot(
                score.seen_until,
                at,
                ">",
                color=INK,
                markersize=5,
                markerfacecolor="white",
                zorder=5,
            )


def _legend(drive: DriveScores) -> list[Line2D]:
    handles = [
        Line2D([], [], color=FIT, alpha=0.65, linewidth=1.6, label="90 % interval"),
        Line2D([], [], color=FIT, alpha=0.65, linewidth=5, label="50 % interval"),
        Line2D([], [], color=INK, linewidth=1.6, label="limit passed"),
        Line2D([], [], color=INK, marker="|", linestyle="", markersize=8, label="forecast made"),
    ]
    if all(score.crossing_seen for score in drive.crossings):
        return handles
    open_end = Line2D([], [], color=INK, marker=">", linestyle="", markerfacecolor="white")
    open_end.set_label("not passed by then")
    return [*handles, open_end]


def _alt(drive: DriveScores) -> str:
    scores = drive.crossings
    missed = [score for score in scores if not score.held[0.9]]
    sides = [_side(score) for score in missed]
    said = f"{capital(counted(len(scores), 'forecast'))} of {drive.name}: "
    if not missed:
        hold, whose = agree(len(scores), "it holds", "all hold"), agree(len(scores), "its", "their")
        return f"{said}{hold} what came later in {whose} 90 % interval."
    if len(missed) == 1:
        who = "it" if len(scores) == 1 else "1"
        how = f"too {sides[0]}" if sides[0] else _BETWEEN
        return f"{said}{who} misses what came later, {how}."
    said += f"{len(missed)} miss what came later"
    early, late, between = (sides.count(side) for side in ("early", "late", ""))
    rest = f", {between} {_BETWEEN}" if between else ""
    return f"{said}, {early} of them too early and {late} too late{rest}."


def _side(score: CrossingScore) -> str:
    """On which side a 90 % interval missed what came; empty where the tests do not tell it."""
    crossed_at = min(score.crossed_at, score.seen_until)
    first, last = score.passed_between or (crossed_at, crossed_at)
    low, high = score.quantiles[0.05], score.quantiles[0.95]
    if high is not None and high < first:
        return "early"
    between = score.passed_between is not None and low is not None and low <= last
    return "" if between else "late"
