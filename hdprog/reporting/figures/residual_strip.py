"""Strips of a residual: its points by branch, the noise band, and lines of what was added."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from hdprog.explanation import Explanation, ResidualCourse
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS
from hdprog.reporting.effect_words import Coordinate, along, carrier, coordinate, unknown_term
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.style import INSPECT, MUTED

RISING = "#0072B2"
FALLING = "#D55E00"
ADDED = INSPECT
SCATTERED = ("rate", "temperature")
"""Coordinates with no course to draw a line along."""


def shown_coordinate(explanation: Explanation) -> str:
    """Coordinate to draw over: the unknown term's, else the one that carries most, else torque."""
    course = explanation.course
    unknown = unknown_term(explanation.effects)
    most = carrier(explanation.carried_by)
    wanted = [
        None if unknown is None else unknown.coordinate,
        None if most is None else most.coordinate,
    ]
    found = next((name for name in wanted if name and name in course.coordinates), "torque")
    return "torque" if found == "branch" else found  # marks tell the directions apart


def coordinate_values(course: ResidualCourse, name: str) -> tuple[FloatArray, Coordinate]:
    """Values (blocks,) of a coordinate in the unit that is shown, and its words."""
    values = along(course, name)
    if values is None or name == "branch":
        said = coordinate("torque")
        return said.factor * course.torque, said
    said = coordinate(name)
    return said.factor * values, said


def centred(course: ResidualCourse) -> tuple[FloatArray, FloatArray]:
    """Residual (blocks,) before and after in rad with its mean over the readings taken out.

    The errors that go with the pictures are those about the mean, as an encoder's zero is free.
    """
    before, after = (
        residual - np.average(residual, weights=course.count)
        for residual in (course.before, course.after)
    )
    return np.asarray(before), np.asarray(after)


def residual_data(explanation: Explanation) -> PictureData:
    """Residual before and after over the coordinate that is drawn."""
    course = explanation.course
    before, after = centred(course)
    values, said = coordinate_values(course, shown_coordinate(explanation))
    columns = ("residual of the drive model alone", "residual with what was added", "noise, 1 sd")
    return PictureData.along(
        f"{explanation.test_id}-residual",
        (said.axis, "torque rises (1) or falls (-1)", *(f"{name} [µrad]" for name in columns)),
        values,
        np.where(course.rising > 0, 1.0, -1.0),
        MICRORADIAN * before,
        MICRORADIAN * after,
        MICRORADIAN * np.broadcast_to(course.noise, before.shape),
    )


def residual_height(course: ResidualCourse) -> float:
    """Half the height of the residual strips in µrad, for before and after alike."""
    before, after = centred(course)
    residual = float(np.quantile(np.abs(before), 0.995))
    moved = float(np.abs(before - after).max())
    largest = max(residual, moved, 3.0 * float(np.median(course.noise)))
    return 1.12 * largest * MICRORADIAN or 1.0


def draw_residual(
    axes: Axes, course: ResidualCourse, at: FloatArray, residual: FloatArray, top: float
) -> None:
    """Draw the residual in µrad, clipped to ± top, over its coordinate with the noise band."""
    noise = 2.0 * MICRORADIAN * float(np.median(course.noise))
    axes.axhspan(-noise, noise, color=MUTED, alpha=0.22, linewidth=0, zorder=0)
    axes.axhline(0, color=MUTED, linewidth=0.7)
    marks: dict[str, Any] = {
        "linestyle": "none",
        "markersize": 3.4,
        "alpha": 0.85,
        "markeredgewidth": 0.8,
        "rasterized": True,
        "clip_on": False,
    }
    for rising, colour, marker, fill in ((True, RISING, "o", RISING), (False, FALLING, "v", "w")):
        side = (course.rising > 0) == rising
        values = np.clip(residual[side], -top, top)
        axes.plot(at[side], values, marker, color=colour, markerfacecolor=fill, zorder=2, **marks)
    axes.set_ylim(-top, top)
    axes.set_ylabel("residual [µrad]")


def draw_line(
    axes: Axes, course: ResidualCourse, at: FloatArray, values: FloatArray, name: str
) -> None:
    """Draw a noiseless course, solid where torque rises and dashed where it falls."""
    if name in SCATTERED:
        axes.plot(at, values, ".", color=ADDED, markersize=3.5, zorder=4)
        return
    for part in _branches(course):
        style = "-" if course.rising[part][0] > 0 else (0, (4, 1.6))
        axes.plot(at[part], values[part], color=ADDED, linestyle=style, linewidth=1.5, zorder=4)


def _branches(course: ResidualCourse) -> Iterator[slice]:
    """Stretches of the record in which torque keeps its direction."""
    turns = np.flatnonzero(np.diff((course.rising > 0).astype(int))) + 1
    edges = [0, *turns.tolist(), course.rising.size]
    return (slice(a, b) for a, b in pairwise(edges) if b - a > 1)


def format_axes(axes: Axes, at: FloatArray, most_ticks: int) -> None:
    """Fit the axis of the coordinate to its values and count the ticks."""
    low, high = float(at.min()), float(at.max())
    margin = 0.015 * (high - low or 1.0)
    axes.set_xlim(low - margin, high + margin)
    axes.xaxis.set_major_locator(MaxNLocator(most_ticks))
    axes.xaxis.set_major_formatter(THOUSANDS)
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_formatter(THOUSANDS)
