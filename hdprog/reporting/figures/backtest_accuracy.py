"""Remaining life as forecast over the share of life gone: the alpha-lambda picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from hdprog.forecast.backtest import ALPHA
from hdprog.forecast.backtest_pool import CrossingCourse
from hdprog.reporting.axes import PERCENT
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.rounding import share
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
from hdprog.reporting.words import counted, quantity

_MARKS = ("o", "s", "^", "D", "v", "P")
_COLOURS = (FIT, SHUTDOWN, INSPECT, LIMIT, MUTED, INK)
_TOP = 1.8  # lives


def accuracy(courses: Sequence[CrossingCourse]) -> Picture | None:
    """Forecast medians and 90 % intervals in lives, beside the truth; None without a crossing."""
    if not courses:
        return None
    figure = new_figure(7.6, 4.2)
    axes = figure.add_axes((0.1, 0.12, 0.87, 0.74))
    gone = np.array([0.0, 1.0])
    axes.fill_between(
        gone,
        (1 - ALPHA) * (1 - gone),
        (1 + ALPHA) * (1 - gone),
        color=MUTED,
        alpha=0.22,
        linewidth=0,
        label=f"within {share(ALPHA)} of it",
    )
    axes.plot(gone, 1 - gone, color=INK, linewidth=1.4, label="true remaining life")
    keys = list(dict.fromkeys(course.key for course in courses))
    for number, course in enumerate(courses):
        look = keys.index(course.key) % len(_MARKS)
        _course(axes, course, look, (number - (len(courses) - 1) / 2) * 0.006)
    for look, key in enumerate(keys):
        axes.plot([], [], _MARKS[look % 6], color=_COLOURS[look % 6], label=quantity(key).name)
    axes.set_xlim(-0.02, 1.0)
    axes.set_ylim(0, _TOP)
    axes.xaxis.set_major_formatter(PERCENT)
    axes.yaxis.set_major_formatter(PERCENT)
    axes.set_xlabel("life gone when the forecast was made (first test to crossing)")
    axes.set_ylabel("remaining life, in parts of the whole")
    axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 1.0), ncols=3)
    inside, count = _inside(courses)
    return picture(
        figure,
        alt=(
            f"{inside} of {counted(count, 'forecast')} put more than even odds within"
            f" {share(ALPHA)} of the true remaining life; {_horizon(courses)}."
        ),
        shows=(
            "Points are the even odds of each forecast, bars its 90 % interval, both as remaining"
            " life in parts of the life from the first test to the crossing. The line is the truth,"
            f" the grey wedge {share(ALPHA)} around it (the alpha-lambda measure). What lies above"
            " the axis is left out."
        ),
        good="points close in on the line from left to right and stay in the wedge.",
        bad="points stay above the line, which is too late, until the very end.",
        action=(
            "the share of life gone at which points enter the wedge for good is how early such a"
            " forecast may be planned by; before it, plan by the early end of the interval."
        ),
        data=_data(courses),
    )


def _data(courses: Sequence[CrossingCourse]) -> PictureData:
    """Every forecast of every crossing in parts of the life; past the horizon the cell is empty."""
    rows = []
    for course in courses:
        life = course.crossed_at - course.first_hours
        for at, score in zip(course.origins, course.scores, strict=True):
            ends = (score.quantiles[level] for level in (0.05, 0.5, 0.95))
            rows.append(
                (
                    course.drive,
                    quantity(course.key).name,
                    (at - course.first_hours) / life,
                    (course.crossed_at - at) / life,
                    *(None if end is None else (end - at) / life for end in ends),
                )
            )
    named = (f"forecast remaining life, {level} %" for level in (5, 50, 95))
    columns = ("drive", "figure", "life gone", "true remaining life", *named)
    return PictureData.of("remaining-life-over-life", columns, rows)


def _course(axes: Axes, course: CrossingCourse, look: int, shift: float) -> None:
    life = course.crossed_at - course.first_hours
    colour = _COLOURS[look]
    points = []
    for at, score in zip(course.origins, course.scores, strict=True):
        gone = (at - course.first_hours) / life + shift
        low, middle, high = (
            np.inf if (edge := score.quantiles[level]) is None else (edge - at) / life
            for level in (0.05, 0.5, 0.95)
        )
        if low < _TOP:
            axes.plot([gone, gone], [low, min(high, _TOP)], color=colour, linewidth=1.3, alpha=0.5)
        if middle < _TOP:
            points.append((gone, middle))
    if points:
        axes.plot(*zip(*points, strict=True), color=colour, linewidth=0.7, alpha=0.5)
        axes.plot(*zip(*points, strict=True), _MARKS[look], color=colour, markersize=5)


def _inside(courses: Sequence[CrossingCourse]) -> tuple[int, int]:
    every = [score.within_alpha or 0.0 for course in courses for score in course.scores]
    return sum(value > 0.5 for value in every), len(every)


def _horizon(courses: Sequence[CrossingCourse]) -> str:
    found = sum(course.prognostic_horizon is not None for course in courses)
    return f"{found} of {counted(len(courses), 'crossing')} had such a forecast at some test"
