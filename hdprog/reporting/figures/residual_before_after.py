"""The residual of one record before and after effects were added, on one scale."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from hdprog.explanation import Explanation, ResidualCourse
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import align_left, title_that_fits
from hdprog.reporting.effect_words import (
    Coordinate,
    effect_name,
    mechanisms,
    unknown_term,
)
from hdprog.reporting.error_words import accounted_for, before_and_after, errors, micro
from hdprog.reporting.figures.residual_strip import (
    ADDED,
    FALLING,
    RISING,
    SCATTERED,
    centred,
    coordinate_values,
    draw_line,
    draw_residual,
    format_axes,
    residual_data,
    residual_height,
    shown_coordinate,
)
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.left_structure import LOOK_IN_RIG
from hdprog.reporting.style import MEASURED, MUTED, Picture, new_figure, picture
from hdprog.reporting.words import agree, listed

_TOP, _BOTTOM, _STRIP, _GAP = 0.32, 0.62, 1.5, 0.34  # inches
_WIDTH = 7.6


def residual_before_after(explanation: Explanation) -> Picture:
    """Residual over the coordinate that carries it, before and after, and what was added.

    Where nothing was added there is one strip only.
    """
    course, effects = explanation.course, explanation.effects
    before, after = centred(course)
    name = shown_coordinate(explanation)
    along, said = coordinate_values(course, name)
    known = mechanisms(effects)
    strips = 1 if not effects else 3 if known else 2
    height = _TOP + _BOTTOM + strips * _STRIP + (strips - 1) * _GAP
    figure = new_figure(_WIDTH, height)
    axes = []
    for index in range(strips):
        bottom = height - _TOP - (index + 1) * _STRIP - index * _GAP
        place = (0.095, bottom / height, 0.885, _STRIP / height)
        axes.append(figure.add_axes(place))
    top = residual_height(course)
    floor = f"noise floor {micro(explanation.noise_floor_rad)} µrad"
    error = f"error {micro(explanation.before.rmse_rad)} µrad, {floor}"
    axes[0].set_title(f"The drive model alone: {error}")
    draw_residual(axes[0], course, along, MICRORADIAN * before, top)
    if effects:
        names = listed(effect_name(effect.id) for effect in effects)
        draw_line(axes[0], course, along, MICRORADIAN * (before - after), name)
        left = f"error {micro(explanation.after.rmse_rad)} µrad"
        title_that_fits(axes[1], f"With {names}: {left}", f"With what was added: {left}")
        draw_residual(axes[1], course, along, MICRORADIAN * after, top)
    if known:
        names = listed(effect_name(effect.id) for effect in known)
        moved = mechanism_course(course)
        size = micro(float(np.sqrt(np.mean(moved**2))))
        adds = agree(len(known), "adds", "add")
        added = f"to the angle: {size} µrad (root mean square)"
        title_that_fits(
            axes[2], f"What {names} {adds} {added}", f"What the known effects add {added}"
        )
        draw_line(axes[2], course, along, MICRORADIAN * moved, name)
        axes[2].axhline(0, color=MUTED, linewidth=0.7)
        axes[2].set_ylabel("angle [µrad]")
    _finish(axes, along, said, name)
    return picture(
        figure,
        alt=error_alt(explanation),
        shows=_shows(explanation, said),
        good=_good(explanation),
        bad="points that leave the band together, or a pattern that rising and falling torque"
        " share: then something still acts that is not in the model.",
        action=residual_action(explanation),
        data=residual_data(explanation),
    )


def mechanism_course(course: ResidualCourse) -> FloatArray:
    """What the known mechanisms add to the angle in rad, (blocks,), without the unknown term."""
    if course.unknown is None:
        return course.added
    return np.asarray(course.added - (course.unknown - course.unknown.mean()))


def _finish(axes: list[Axes], along: FloatArray, said: Coordinate, name: str) -> None:
    """Share the axis of the coordinate and put one legend below."""
    for strip in axes:
        format_axes(strip, along, 8)
        strip.tick_params(labelbottom=strip is axes[-1])
    align_left(axes)
    axes[-1].set_xlabel(said.axis, labelpad=1)
    _legend(axes, name)


def _legend(axes: list[Axes], name: str) -> None:
    last = axes[-1]
    handles: list[Any] = [
        *last.plot([], [], "o", color=RISING, markersize=4.5, label="torque rises"),
        *last.plot(
            [], [], "v", color=FALLING, markerfacecolor="w", markersize=4.5, label="torque falls"
        ),
        last.fill_between([], [], color=MUTED, alpha=0.22, label="noise, 95 %"),
    ]
    if len(axes) > 1:
        style: dict[str, Any] = {"linestyle": "-"}
        if name in SCATTERED:
            style = {"marker": ".", "linestyle": "none"}
        label = "effect of what was added (dashed: torque falls)"
        handles += last.plot([], [], color=ADDED, label=label, **style)
    last.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(-0.02, -0.22),
        ncols=4,
        columnspacing=1.4,
        labelcolor=MEASURED,
    )


def _shows(explanation: Explanation, said: Coordinate) -> str:
    text = (
        f"Measured minus fitted angle over {said.name}. Filled circles: torque rises; open"
        " triangles: torque falls; grey band: noise of a point (± 2 standard deviations)."
    )
    if not explanation.effects:
        return text
    several = len(explanation.effects)
    text += (
        " Above: the drive model alone, its parameters fitted as well as they go; the line is what"
        f" changes in the fit when the {agree(several, 'effect is', 'effects are')} added. Next, on"
        " the same scale: what is left then."
    )
    known = len(mechanisms(explanation.effects))
    if known:
        text += (
            f" Below, on its own scale: the {agree(known, 'effect by itself', 'effects together')}."
            " Where that is larger than the residual above, the drive model had hidden the rest of"
            " it in wrong parameters."
        )
    return text


def _good(explanation: Explanation) -> str:
    lead = "with what was added, " if explanation.effects else ""
    return f"{lead}the points fill the grey band evenly, on both branches."


def error_alt(explanation: Explanation) -> str:
    """Say what a record's error was before and is after."""
    if not explanation.effects:
        said = before_and_after(errors(explanation))
        return f"Test {explanation.test_id}: the drive model alone leaves {said}."
    names = listed(effect_name(effect.id) for effect in explanation.effects)
    said = before_and_after(errors(explanation))
    return f"Test {explanation.test_id}: with {names} the error goes {said}."


def residual_action(explanation: Explanation) -> str:
    """Say what to do about what is left."""
    if not explanation.converged:
        return "do not act on this yet: a fit did not converge; run it again, not quick."
    if not explanation.effects:
        return "nothing." if accounted_for(errors(explanation)) else LOOK_IN_RIG
    if unknown_term(explanation.effects) is not None:
        return (
            "take the part that no mechanism describes for what it is: look in the rig for what "
            "happens there, and repeat the record."
        )
    return f"follow the advice on {agree(len(explanation.effects), 'the', 'each')} effect."
