"""The shape of what no known mechanism describes, over the coordinate that carries it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from hdprog.explanation import Explanation
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS, align_left
from hdprog.reporting.effect_words import unknown_place, unknown_term
from hdprog.reporting.figures.residual_strip import (
    ADDED,
    FALLING,
    RISING,
    centred,
    coordinate_values,
)
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.rounding import significant
from hdprog.reporting.style import MUTED, Picture, new_figure, picture


def unknown_course(explanation: Explanation) -> Picture | None:
    """Curve of the unknown term with the readings that it follows; None without such a term."""
    course, term = explanation.course, unknown_term(explanation.effects)
    if term is None or term.coordinate is None or course.unknown is None:
        return None
    along, said = coordinate_values(course, term.coordinate)
    curve = MICRORADIAN * (course.unknown - np.median(course.unknown))
    points = curve + MICRORADIAN * centred(course)[1]
    figure = new_figure(7.6, 3.1)
    axes = figure.add_axes((0.095, 0.235, 0.885, 0.735))
    rising = course.rising > 0
    marks: dict[str, Any] = {"linestyle": "none", "markersize": 3.2, "alpha": 0.45}
    marks |= {"markeredgewidth": 0.6, "rasterized": True}
    for side, colour, marker, fill, label in (
        (rising, RISING, "o", RISING, "left over, torque rises"),
        (~rising, FALLING, "v", "w", "left over, torque falls"),
    ):
        axes.plot(
            along[side],
            points[side],
            marker,
            color=colour,
            markerfacecolor=fill,
            label=label,
            **marks,
        )
    if term.coordinate == "branch":  # a curve for each direction
        parts = [(rising, "-", "unknown term"), (~rising, (0, (4, 1.6)), "where torque falls")]
    else:
        parts = [(np.ones_like(rising), "-", "unknown term")]
    for part, style, label in parts:
        line = _in_order(along[part], curve[part])
        axes.plot(*line, color=ADDED, linestyle=style, linewidth=2.2, label=label)
    axes.axhline(0, color=MUTED, linewidth=0.7)
    axes.set_xlabel(said.axis, labelpad=1)
    axes.set_ylabel("angle [µrad]")
    axes.yaxis.set_major_locator(MaxNLocator(6))
    axes.xaxis.set_major_locator(MaxNLocator(8))
    axes.xaxis.set_major_formatter(THOUSANDS)
    axes.yaxis.set_major_formatter(THOUSANDS)
    align_left([axes])
    axes.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.15), ncols=4, columnspacing=1.4)
    height = significant(float(np.ptp(curve)), 2)
    place = unknown_place(course, term.coordinate)
    return picture(
        figure,
        alt=f"Test {explanation.test_id}: what no known mechanism describes lies {place}; it moves "
        f"the angle by {height} µrad from its lowest to its highest point.",
        shows=f"The empirical curve over {said.name}, its median taken as zero, and the readings "
        "that it follows once everything else is taken off. It is a smooth curve through the data "
        "and stands for no mechanism.",
        good="none is needed.",
        bad="a clear shape that comes back in the next record: it is real, and the model lacks it.",
        action=_action(term.coordinate),
        data=PictureData.along(
            f"{explanation.test_id}-unknown",
            (said.axis, "unknown term [µrad]", "readings it follows [µrad]"),
            along,
            curve,
            points,
        ),
    )


def _in_order(along: FloatArray, curve: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Curve in the order of its coordinate, equal places taken together."""
    places, which = np.unique(along, return_inverse=True)
    return places, np.bincount(which, curve) / np.bincount(which)


def _action(name: str) -> str:
    same = {
        "time": "the same moment of the record",
        "order": "the same moment of the record",
        "torque": "the same torque",
        "branch": "the same torque",
        "angle": "the same torsion angle",
        "output_angle": "the same output angle",
        "temperature": "the same temperature",
    }
    at = same.get(name, "the same place")
    return f"repeat the record; if the shape comes back at {at}, it is no accident: look there."
