from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from hdprog.reporting.axes import (
    THOUSANDS,
    Event,
    align_left,
    mark_events,
    ticks_inside,
    title_that_fits,
)
from hdprog.reporting.figures.residual_strip import draw_residual, format_axes, residual_height
from hdprog.reporting.figures.trend_fan import visible_hours
from hdprog.reporting.rounding import THIN_SPACE
from hdprog.reporting.style import house_style, new_figure
from tests.reporting import drives, explanations


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


@pytest.mark.parametrize("count", [3, 12, 60])
def test_however_many_events_leave_the_axes_their_height(count: int) -> None:
    with house_style():
        figure = new_figure(7.6, 3.3)
        axes = figure.add_axes((0.1, 0.15, 0.85, 0.65))
        axes.set_xlim(0.0, 10_000.0)
        regreased = [Event(150.0 * n, "regreased", "grey", ":") for n in range(1, count + 1)]
        mark_events(axes, [Event(9_900.0, "now", "black", "-"), *regreased])
        assert axes.get_position().height > 0.55
        assert len(axes.lines) == count + 1
        texts = [text.get_text() for text in axes.texts]
        assert texts[0] == "now"
        assert texts.count("regreased") == count if count == 3 else 4 < len(texts) <= count


@pytest.mark.parametrize(
    "shutdown", [1_500.0, 2_300.0, 2_700.0, 2_900.0, 3_100.0, 3_500.0, 5_800.0]
)
def test_no_line_of_an_event_runs_through_the_label_of_another(shutdown: float) -> None:
    """That of the shutdown did through the date to inspect before."""
    events = [
        Event(900.0, "now"),
        Event(2_800.0, f"inspect before 2{THIN_SPACE}800{THIN_SPACE}h"),
        Event(shutdown, f"next shutdown {shutdown:.0f}{THIN_SPACE}h: 7.2{THIN_SPACE}%", line="--"),
    ]
    with house_style():
        axes = new_figure(7.6, 3.3).add_axes((0.09, 0.15, 0.88, 0.65))
        axes.set_xlim(850.0, 6_000.0)
        mark_events(axes, events)
        FigureCanvasAgg(axes.get_figure(root=True)).draw()
        boxes = [text.get_window_extent() for text in axes.texts]
        ends = [line.get_path().transformed(line.get_transform()).vertices for line in axes.lines]
    assert len(boxes) == len(ends) == len(events)
    for line, box in itertools.permutations(range(3), 2):
        x, top = ends[line][0, 0], ends[line][:, 1].max()
        assert not (boxes[box].x0 <= x <= boxes[box].x1 and top > boxes[box].y0)
    assert not any(one.overlaps(two) for one, two in itertools.combinations(boxes, 2))


def test_a_title_too_long_for_its_axes_is_shortened() -> None:
    with house_style():
        axes = new_figure(7.6, 2.0).add_axes((0.55, 0.2, 0.43, 0.7))
        title_that_fits(axes, "With creep: 15 µrad", "With what was added: 15 µrad")
        assert axes.get_title("left") == "With creep: 15 µrad"
        long = "With Coulomb friction and torque sensor hysteresis: 15 µrad"
        title_that_fits(axes, long, "With what was added: 15 µrad")
        assert axes.get_title("left") == "With what was added: 15 µrad"


@pytest.mark.parametrize(
    ("low", "high"), [(-2e5, 2.5e6), (500.0, 8_100.0), (2_400.0, 17_000.0), (8.0, 42.0)]
)
def test_tick_labels_stay_inside_their_panel_and_apart(low: float, high: float) -> None:
    with house_style():
        figure = new_figure(7.6, 2.0)
        axes = figure.add_axes((0.115, 0.2, 0.205, 0.7))
        axes.tick_params(labelsize=7.6)
        axes.set_xlim(low, high)
        axes.xaxis.set_major_formatter(THOUSANDS)
        ticks_inside(axes)
        FigureCanvasAgg(figure).draw()
        boxes = [label.get_window_extent() for label in axes.xaxis.get_ticklabels()]
        panel = axes.get_window_extent()
    assert len(boxes) >= 2
    assert all(panel.x0 - 1.0 <= box.x0 and box.x1 <= panel.x1 + 1.0 for box in boxes)
    assert all(one.x1 < other.x0 for one, other in itertools.pairwise(boxes))


def test_a_late_end_of_the_crossing_leaves_the_tests_room() -> None:
    """At 17 000 h of 900 h measured the tests had stood in a twentieth of the picture."""
    result = drives.wearing(drives.LOST_MOTION, crossing=1_300.0, count=4)
    limit, trend = drives.LOST_MOTION, result.trend
    assert trend is not None
    figure = trend.figures[limit.key]
    for spread, most in ((0.1, 2_000.0), (3.0, 4_500.0)):
        crossings = 900.0 + 400.0 * np.exp(spread * np.linspace(-2.0, 2.0, 401))
        first, end = visible_hours(figure, drives.forecast_of(limit, crossings, 900.0))
        assert first < 0.0
        assert 1_300.0 < end <= most


def test_small_numbers_of_an_axis_are_written_in_one_way() -> None:
    texts = [THOUSANDS(value, 0) for value in (-0.0001, -8e-05, 0.0, 2e-05, 0.0001, 1e-8)]
    assert texts == ["−0.0001", "−0.00008", "0", "0.00002", "0.0001", "0.00000001"]
    assert THOUSANDS(123456.0, 0) == f"123{THIN_SPACE}456"
