"""The picture of remaining life: its words stand clear of one another."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hdprog.reporting.figures.remaining_life import _draw_density, remaining_life
from hdprog.reporting.style import house_style, new_figure
from hdprog.results import Forecast
from tests.reporting.drives import LOST_MOTION, forecast_of
from tests.reporting.page import spaced


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


@pytest.mark.parametrize(("never", "highest"), [(0.0, 1.0), (0.98, 0.25)])
def test_what_hardly_ever_happens_makes_no_mountain(never: float, highest: float) -> None:
    hours = np.linspace(1500.0, 2500.0, 4000)
    hours[np.random.default_rng(3).random(4000) < never] = np.inf
    with house_style():
        axes = new_figure(7.6, 1.6).add_axes((0.09, 0.1, 0.88, 0.75))
        _draw_density(axes, forecast_of(LOST_MOTION, hours, 900.0), 2600.0)
    _, drawn = axes.lines[0].get_data()
    assert 0.5 * highest < np.max(drawn) / axes.get_ylim()[1] < highest


@pytest.mark.parametrize(
    ("ends", "words"),
    [
        ((1500.0, 2500.0), "the darker part holds 90 %, the marks are 5, 50 and 95 %."),
        ((5000.0, 30_000.0), "the darker part lies past 5 %, the marks are 5 and 50 %."),
        ((15_000.0, 40_000.0), "the darker part lies past 5 %, the mark is 5 %."),
        ((25_000.0, 40_000.0), "if nothing is done. Below"),
    ],
)
def test_words_name_the_marks_that_are_drawn(ends: tuple[float, float], words: str) -> None:
    """They named 95 % where it lies past the horizon, and a darker part of 90 % with it."""
    with house_style():
        drawn = remaining_life((evenly(*ends),), None, doubtful=False)
    assert words in spaced(drawn.shows)


def evenly(first: float, last: float) -> Forecast:
    return forecast_of(LOST_MOTION, np.linspace(first, last, 4000), 900.0)


@pytest.mark.parametrize("count", [2, 3, 5, 8])
def test_the_legend_has_room_for_every_limit(count: int) -> None:
    """The last row of six entries was cut off."""
    limits = [replace(LOST_MOTION, threshold=2.0 + 0.1 * n) for n in range(count)]
    hours = np.linspace(1500.0, 2500.0, 400)
    forecasts = [forecast_of(limit, hours, 900.0) for limit in limits]
    with house_style(), pytest.MonkeyPatch.context() as patch:
        drawn: list[Figure] = []
        patch.setattr(
            "hdprog.reporting.figures.remaining_life.picture",
            lambda figure, **words: drawn.append(figure),
        )
        remaining_life((*forecasts, forecast_of(None, hours, 900.0)), None, doubtful=False)
        (figure,) = drawn
        FigureCanvasAgg(figure).draw()
        axes = figure.axes[0]
        legend, label = axes.get_legend(), axes.xaxis.label.get_window_extent()
        assert legend is not None
        box = legend.get_window_extent()
    assert len(legend.get_texts()) == count + 1
    assert 0.0 <= box.y0 < 0.12 * figure.dpi
    assert box.y1 < label.y1
