"""Hours of skewed forecasts: a median is told inside its own interval."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.reporting import outlook
from hdprog.reporting.forecast_words import interval_words, middle_words
from hdprog.reporting.rounding import THIN_SPACE, hours
from tests.reporting.drives import LOST_MOTION, forecast_of

NOW = 900.0


def number(text: str) -> float:
    return float(text.removesuffix(f"{THIN_SPACE}h").replace(THIN_SPACE, ""))


@pytest.mark.parametrize("late", [500.0, 6000.0, 19_000.0])
def test_a_median_near_the_early_end_is_not_rounded_past_it(late: float) -> None:
    levels = {"q05": 140.0, "q50": 280.0, "q95": late}
    early, end = interval_words(levels, NOW).split(" to ")
    assert number(early) < number(middle_words(levels, NOW)) < number(end)


def test_the_report_rounds_the_median_of_a_skewed_forecast_by_its_nearer_end() -> None:
    rng = np.random.default_rng(3)
    crossings = NOW + 280.0 * np.exp(np.abs(rng.standard_normal(4000)) * 2.0 - 1.0)
    forecast = forecast_of(LOST_MOTION, crossings, NOW, horizon=80_000.0)
    told = outlook.crossing_hours(forecast)
    early, median = told[0.05], told[0.50]
    assert early is not None
    assert median is not None
    assert outlook.spread(forecast) > median - early
    shown = number(hours(median, outlook.spread_about_median(forecast)))
    assert abs(shown - median) <= 0.1 * (median - early)
