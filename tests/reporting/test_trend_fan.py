"""What the picture of a trend marks and asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.reporting.figures.trend_fan import _draw_tests, trend_fan
from hdprog.reporting.style import house_style, new_figure
from hdprog.results import DriveResult
from tests.reporting import drives

KEY = drives.LOST_MOTION.key


def test_of_two_tests_at_the_same_hours_the_one_that_did_not_converge_is_marked() -> None:
    """As before and after regreasing."""
    result = drives.wearing(count=3, samples=600)
    assert result.trend is not None
    before, _, last = result.tests
    after = replace(last, test_id="t02b", service_hours=last.service_hours)
    tests = (before, replace(last, converged=False), after)
    trend = result.trend.figures[KEY]
    hours = np.array([test.service_hours for test in tests], dtype=float)
    axes = new_figure(4.0, 3.0).add_axes((0.1, 0.1, 0.8, 0.8))
    _draw_tests(axes, replace(trend, test_hours=hours), tests)
    (ring,) = [line for line in axes.lines if line.get_label() == "not converged"]
    assert np.asarray(ring.get_ydata()).tolist() == [trend.test_quantiles[2, 1]]


@pytest.mark.parametrize(
    ("result", "action"),
    [
        (drives.past_limit(), "inspect now; "),
        (drives.wearing(count=2), "test again before the inspection hour; "),
        (drives.healthy(), "where points leave the fan, "),
    ],
)
def test_it_asks_for_what_the_verdict_does(result: DriveResult, action: str) -> None:
    assert result.trend is not None
    with house_style():
        drawn = trend_fan(
            result.trend.figures[KEY], result.forecasts[0], result.tests, doubtful=False
        )
    assert drawn.action.startswith(action)
    # What a caption explains is there to be seen.
    assert ("hill" in drawn.shows) == (not result.forecasts[0].already_crossed)
