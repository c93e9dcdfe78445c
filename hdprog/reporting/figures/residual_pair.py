"""The residual of one of a drive's tests, before and after side by side."""

from __future__ import annotations

from hdprog.explanation import Explanation
from hdprog.reporting.axes import put_y_labels, room_on_the_left, title_that_fits
from hdprog.reporting.effect_words import effect_name
from hdprog.reporting.error_words import micro
from hdprog.reporting.figures.residual_before_after import error_alt, residual_action
from hdprog.reporting.figures.residual_strip import (
    centred,
    coordinate_values,
    draw_line,
    draw_residual,
    format_axes,
    residual_data,
    shown_coordinate,
)
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.style import Picture, new_figure, picture
from hdprog.reporting.words import listed

_BOTTOM, _HEIGHT, _GAP = 0.23, 0.63, 0.025  # parts of the figure


def residual_pair(explanation: Explanation, top: float) -> Picture:
    """Residual before (left, with what the added effects change in the fit) and after (right).

    Parameters
    ----------
    explanation : of a test that carries an effect
    top : half the height in µrad of both strips, the same for all tests of a drive
    """
    course = explanation.course
    old, new = centred(course)
    name = shown_coordinate(explanation)
    along, said = coordinate_values(course, name)
    figure = new_figure(7.6, 2.15)
    before = figure.add_axes((0.095, _BOTTOM, 0.43, _HEIGHT))
    after = figure.add_axes((0.55, _BOTTOM, 0.43, _HEIGHT))
    draw_residual(before, course, along, MICRORADIAN * old, top)
    draw_line(before, course, along, MICRORADIAN * (old - new), name)
    draw_residual(after, course, along, MICRORADIAN * new, top)
    names = listed(effect_name(effect.id) for effect in explanation.effects)
    for axes in (before, after):
        format_axes(axes, along, 6)
        axes.set_xlabel(said.axis, labelpad=1)
    after.set_ylabel("")
    after.tick_params(labelleft=False)
    left = room_on_the_left([before])
    width = (0.98 - left - _GAP) / 2
    before.set_position((left, _BOTTOM, width, _HEIGHT))
    after.set_position((left + width + _GAP, _BOTTOM, width, _HEIGHT))
    put_y_labels([before])
    before.set_title(f"Drive model alone: {micro(explanation.before.rmse_rad)} µrad")
    error = f"{micro(explanation.after.rmse_rad)} µrad"
    title_that_fits(after, f"With {names}: {error}", f"With what was added: {error}")
    return picture(
        figure,
        alt=error_alt(explanation),
        shows=(
            f"Measured minus fitted angle over {said.name}, left for the drive model alone, right"
            " with what was added. Filled circles: torque rises; open triangles: torque falls; grey"
            " band: noise of a point (± 2 standard deviations). The line is the change of the fit"
            " by what was added, dashed where torque falls. All tests have the same scale."
        ),
        good="on the right the points fill the grey band evenly, on both branches.",
        bad="points on the right that leave the band together: then something still acts that is"
        " not in the model.",
        action=residual_action(explanation),
        data=residual_data(explanation),
    )
