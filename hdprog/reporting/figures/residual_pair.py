"""The residual of one of a drive's tests, before and after side by side."""

from __future__ import annotations

from hdprog.explanation import Explanation
from hdprog.reporting.effect_words import effect_name, micro
from hdprog.reporting.figures.residual_before_after import error_alt, residual_action
from hdprog.reporting.figures.residual_strip import (
    coordinate_values,
    draw_line,
    draw_residual,
    format_axes,
    shown_coordinate,
)
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.style import Picture, new_figure, picture
from hdprog.reporting.words import listed


def residual_pair(explanation: Explanation, top: float) -> Picture:
    """Residual before (left, with what the added effects change in the fit) and after (right).

    Parameters
    ----------
    explanation : of a test that carries an effect
    top : half the height in µrad of both strips, the same for all tests of a drive
    """
    course = explanation.course
    name = shown_coordinate(explanation)
    along, said = coordinate_values(course, name)
    figure = new_figure(7.6, 2.15)
    before = figure.add_axes((0.095, 0.23, 0.43, 0.63))
    after = figure.add_axes((0.55, 0.23, 0.43, 0.63))
    draw_residual(before, course, along, MICRORADIAN * course.before, top)
    draw_line(before, course, along, MICRORADIAN * (course.before - course.after), name)
    draw_residual(after, course, along, MICRORADIAN * course.after, top)
    names = listed(effect_name(effect.id) for effect in explanation.effects)
    for axes, title, error in (
        (before, "Drive model alone", explanation.before.rmse_rad),
        (after, f"With {names}", explanation.after.rmse_rad),
    ):
        axes.set_title(f"{title}: {micro(error)} µrad")
        format_axes(axes, along, 6)
        axes.set_xlabel(said.axis, labelpad=1)
    after.set_ylabel("")
    after.tick_params(labelleft=False)
    return picture(
        figure,
        alt=error_alt(explanation),
        shows=(
            f"Measured minus fitted angle over {said.name}, left for the drive model alone, right"
            " with what was added. Filled circles: torque rises; open triangles: torque falls; grey"
            " band: noise of a point (± 2 standard deviations). The line is what changes in the fit"
            " when the effect is added, dashed where torque falls. All tests have the same scale."
        ),
        good="on the right the points fill the grey band evenly, on both branches.",
        bad="points on the right that leave the band together: then something still acts that is"
        " not in the model.",
        action=residual_action(explanation),
    )
