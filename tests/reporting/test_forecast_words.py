"""Hours of skewed forecasts: a median is told inside its own interval."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.reporting import outlook
from hdprog.reporting.effect_words import remaining_cells
from hdprog.reporting.forecast_words import inspect_words, interval_words, middle_words
from hdprog.reporting.rounding import THIN_SPACE, date_down, hours
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


def test_an_interval_does_not_begin_before_now() -> None:
    levels = {"q05": 60.0, "q50": 900.0, "q95": 12_000.0}
    early, _ = interval_words(levels, 1450.0).split(" to ")
    assert 1450.0 <= number(early) <= 1510.0


def test_an_interval_without_a_late_end_begins_no_later_than_it_does() -> None:
    early, _ = interval_words({"q05": 9437.6, "q50": None, "q95": None}, 1000.0).split(" to ")
    assert number(early) <= 10_437.6


def test_lists_tell_the_date_that_the_report_tells() -> None:
    """Of a forecast whose late end lies past the horizon."""
    crossings = np.where(np.arange(4000) % 10 < 6, np.inf, np.linspace(9000.0, 15_000.0, 4000))
    forecast = forecast_of(LOST_MOTION, crossings, NOW, horizon=20_000.0)
    levels = {f"q{round(100 * level):02d}": at for level, at in forecast.remaining_hours.items()}
    at = forecast.inspect_before_hours
    assert at is not None
    told = hours(date_down(at, NOW, outlook.spread(forecast)))
    assert inspect_words(at, NOW, levels, forecast.horizon_hours) == told


def test_what_is_left_is_rounded_down_at_its_early_end() -> None:
    early, middle, late = map(number, remaining_cells({0.05: 620.0, 0.5: 900.0, 0.95: 12_000.0}))
    assert 496.0 <= early <= 620.0 < middle <= 930.0
    assert late >= 12_000.0
    assert number(remaining_cells({0.05: 400.0, 0.5: 3000.0, 0.95: 12_000.0})[0]) >= 320.0
