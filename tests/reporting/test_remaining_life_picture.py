"""The picture of remaining life: its words stand clear of one another."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from hdprog.reporting.figures.remaining_life import _draw_density
from hdprog.reporting.style import house_style, new_figure
from tests.reporting.drives import LOST_MOTION, forecast_of


def test_levels_that_lie_close_to_now_are_told_apart() -> None:
    """Much of this forecast is at hand, some of it far away: 5 % and 50 % stood on each other."""
    ahead = np.exp(np.log(30.0) + 2.2 * np.random.default_rng(3).standard_normal(4000))
    main = forecast_of(LOST_MOTION, 900.0 + ahead, 900.0)
    with house_style():
        figure = new_figure(7.6, 1.6)
        axes = figure.add_axes((0.09, 0.1, 0.88, 0.75))
        axes.set_xlim(900.0, 2100.0)
        _draw_density(axes, main, 2100.0)
        figure.canvas.draw()
        levels = [text for text in axes.texts if text.get_text().endswith("%")]
        boxes = [text.get_window_extent() for text in levels[:3]]
    assert [text.get_text()[:2].strip("\u202f") for text in levels[:3]] == ["5", "50", "95"]
    assert not any(one.overlaps(two) for one, two in pairwise(boxes))
