"""What a report says of temperature."""

from __future__ import annotations

from dataclasses import replace

from hdprog.reporting.temperature_words import as_if_at, temperature_words
from hdprog.reporting.words import tidy
from hdprog.results import LEVELS, TemperatureEffect
from tests.reporting.drives import trend_summary

WIDTH, LOST = "hysteresis_width_arcmin", "lost_motion_arcmin"
TREND = trend_summary({})


def test_nothing_is_said_where_tests_do_not_differ() -> None:
    assert temperature_words(TREND, [WIDTH]) == ""
    assert as_if_at(None) == ""


def test_the_reference_and_the_change_of_limited_figures() -> None:
    levels = dict(zip(LEVELS, (-11.2, -9.1, -8.2, -7.0, -5.3), strict=True))
    found = TemperatureEffect(23.6, 8.4, 0, {WIDTH: levels, LOST: levels})
    said = tidy(temperature_words(replace(TREND, temperature=found), [WIDTH, WIDTH]))
    assert said.replace("\u00a0", " ").replace("\u2009", " ").replace("\u202f", " ") == (
        "Trend and forecast are told at 24 °C, the mean of the tests. What 10 K more change: "
        "hysteresis width by −8 % (90 %: −11 to −5 %)."
    )
    doubtful = replace(TREND, temperature=replace(found, unknown=2))
    assert "; 2 tests without a temperature are taken at it, give or take 8.4 K." in (
        temperature_words(doubtful, [])
    )
    assert as_if_at(found.reference_C) == " as it would be at 24 °C"


def test_a_trend_that_did_not_converge_says_so_of_temperature_too() -> None:
    doubtful = replace(TREND, temperature=TemperatureEffect(24.0, 5.0, 0, {}), converged=False)
    assert temperature_words(doubtful, []).startswith("Not converged: provisional numbers. Trend")
