from __future__ import annotations

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from hdprog.reporting.axes import align_left, title_that_fits
from hdprog.reporting.figures.residual_strip import draw_residual, format_axes, residual_height
from hdprog.reporting.style import house_style, new_figure
from tests.reporting import explanations


@pytest.mark.parametrize("scale", [1.0, 300.0])
def test_labels_of_many_digits_have_room(scale: float) -> None:
    record = explanations.record(scale=scale)
    with house_style():
        figure = new_figure(7.6, 2.0)
        axes = figure.add_axes((0.095, 0.2, 0.885, 0.7))
        top = residual_height(record.course)
        draw_residual(axes, record.course, record.course.torque, 0.0 * record.course.torque, top)
        format_axes(axes, record.course.torque, 8)
        align_left([axes])
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        labels = axes.yaxis.get_ticklabels()
        assert max(len(label.get_text()) for label in labels) == (3 if scale == 1.0 else 7)
        widest = min(label.get_window_extent().x0 for label in labels)
        name = axes.yaxis.label.get_window_extent()
        assert name.x0 >= 0.0
        assert name.x1 < widest
        assert axes.get_position().x1 == pytest.approx(0.98)


def test_a_title_too_long_for_its_axes_is_shortened() -> None:
    with house_style():
        axes = new_figure(7.6, 2.0).add_axes((0.55, 0.2, 0.43, 0.7))
        title_that_fits(axes, "With creep: 15 µrad", "With what was added: 15 µrad")
        assert axes.get_title("left") == "With creep: 15 µrad"
        long = "With Coulomb friction and torque sensor hysteresis: 15 µrad"
        title_that_fits(axes, long, "With what was added: 15 µrad")
        assert axes.get_title("left") == "With what was added: 15 µrad"
