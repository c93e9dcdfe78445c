"""What a backtest's report says, of forecasts that are made up."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from hdprog.config import Limit
from hdprog.forecast.backtest import FigureScore, OriginScores, score_crossing
from hdprog.forecast.backtest_pool import (
    BacktestResult,
    Coverage,
    CrossingCourse,
    DriveScores,
    Lateness,
    crossing_courses,
)
from hdprog.forecast.crossing import Crossing
from hdprog.reporting.backtest import build_backtest_report
from hdprog.reporting.backtest_json import backtest_json
from hdprog.reporting.backtest_words import late_words, verdict
from hdprog.reporting.figures.backtest_coverage import CoverageRow, coverage
from hdprog.reporting.figures.backtest_intervals import _passed, forecast_intervals
from hdprog.reporting.sections.backtest import accuracies, by_drive, by_known, method
from hdprog.reporting.sections.table import Value
from hdprog.reporting.style import house_style
from hdprog.results import Provenance
from tests.reporting.page import Page, spaced
from tests.reporting.test_picture_data import read

LOST = Limit("lost_motion_arcmin", 2.0, "above")
MADE = Provenance("0", 0, False, "hdprog backtest x", "2026-01-01T00:00:00+00:00", {}, {})


def origin(name: str, now: float, crossed_at: float, *, converged: bool = True) -> OriginScores:
    """Forecast a crossing evenly between 400 and 600 h after now."""
    hours = np.array([now, now + 400.0, now + 600.0, 5000.0])
    crossing = Crossing(hours, np.array([0.0, 0.0, 1.0, 1.0]), already=False, paths=1000)
    score = score_crossing(LOST, crossing, crossed_at, 5000.0, True, 0.5, 5000.0)
    levels = {0.05: 0.9, 0.25: 1.0, 0.5: 1.1, 0.75: 1.2, 0.95: 1.3}
    held = {0.5: True, 0.9: True}
    next_test = FigureScore(LOST.key, "next", now + 50, 1, 1.1, levels, held, 0.02, 0.5, 0.04)
    return OriginScores(name, now, 0.0, 3, converged, (score,), (), (next_test,))


def drive(name: str, crossed_at: float, **options: bool) -> DriveScores:
    return DriveScores(name, name, 2, 5000.0, (), (origin("t01", 0.0, crossed_at, **options),))


def result(*drives: DriveScores) -> BacktestResult:
    return BacktestResult("fleet", drives, (), MADE, {})


def words(*drives: DriveScores) -> str:
    return spaced(verdict(result(*drives)).text)


def test_three_forecasts_get_no_verdict() -> None:
    found = result(*(drive(f"d{n}", 500.0) for n in range(3)))
    assert verdict(found).label == "Too few forecasts for a verdict"
    text = words(*found.drives)
    # Clopper-Pearson of 3 of 3: 0.025^(1/3) = 29 %.
    assert "Of 3 forecasts of 3 crossings, 3 held the crossing in their 90 % interval" in text
    assert "100 % (29 to 100 %) by count, where 90 % should" in text
    assert "3 limits are too few for a verdict" in text
    assert "Typically the even odds came on time." in text


@pytest.mark.parametrize(
    ("crossed_at", "label", "late"),
    [
        (1000.0, "Intervals too narrow", "50 % of the remaining life early"),
        (500.0, "Held as often as they should", "on time"),
    ],
)
def test_many_drives_get_a_verdict(crossed_at: float, label: str, late: str) -> None:
    found = result(*(drive(f"d{n}", crossed_at) for n in range(12)))
    assert verdict(found).label == label
    assert late in words(*found.drives)
    assert "too few" not in words(*found.drives)


def test_where_what_came_ends_is_not_called_the_horizon() -> None:
    """Scores end at the last test, long before the horizon that the drive declares."""
    (made,) = drive("d", 500.0).origins
    short = replace(made, crossings=(replace(made.crossings[0], seen_until=900.0),))
    found = result(DriveScores("d", "d", 2, 5000.0, (), (short,)))
    text = spaced(method(found)[-1].text)
    assert "as far as what came was seen (to 900 h), not how the next drive's will be" in text
    two = method(result(*found.drives, drive("e", 500.0)))[-1].text
    assert "as far as what came was seen, not how" in two


def test_one_forecast_has_one_interval() -> None:
    seen = words(drive("d", 500.0))
    assert "Of 1 forecast of 1 crossing, 1 held the crossing in its 90 % interval" in seen
    seen_not = words(drive("d", math.inf))
    assert "0 of them hold it in its 90 % interval" in seen_not


def test_what_did_not_converge_comes_first() -> None:
    found = verdict(result(drive("d1", 500.0, converged=False)))
    assert found.provisional
    assert found.label.endswith("provisional")
    assert found.sentences[0].startswith("Not converged: the trend up to t01.")


def test_a_share_that_is_not_the_intervals_own_has_its_reason() -> None:
    """Of 90 % intervals 95 % should hold: without a word a contradiction."""
    past = drive("d", 500.0)
    score = replace(past.origins[0].crossings[0], own_probability={0.5: 0.5, 0.9: 0.95})
    past = replace(past, origins=(replace(past.origins[0], crossings=(score,)),))
    assert "95 % should, as intervals that run past what was seen hold more" in words(past)
    # With the same digits in the tables, which had "1, should be 0.9".
    for table in (by_drive(result(past)), by_known(result(past))):
        cells = [
            spaced(str(cell)) for group in table.groups for row in group.rows for cell in row.cells
        ]
        assert "1 of 1, 95 % should" in cells
        assert "1 of 1, 50 % should" in cells


def test_lateness_in_words() -> None:
    each = [Lateness(late, within_tests=False) for late in (0.12, -0.03, math.inf, 0.001)]
    assert [spaced(late_words(late)) for late in (*each, None)] == [
        "12 % late",
        "3 % early",
        "past the horizon",
        "on time",
        "\u2013",
    ]
    assert late_words(Lateness(0.12, within_tests=True)) == "between its tests"


def test_a_forecast_between_the_tests_of_the_crossing_is_neither_early_nor_late() -> None:
    """The crossing is read off a straight line, which wear that speeds up passes below."""
    between = "Typically the even odds came between the two tests between which the limit was"
    for crossed_at, told, cell in (
        (420.0, between, "between its tests"),  # 80 h late by the straight line
        (620.0, "19 % of the remaining life early", "120 h early"),
    ):
        exact = drive("d", crossed_at)
        score = exact.origins[0].crossings[0]
        seen = replace(score, from_truth=False, passed_between=(crossed_at - 20, crossed_at + 100))
        found = replace(exact, origins=(replace(exact.origins[0], crossings=(seen,)),))
        assert told in words(found)
        assert between not in words(exact)
        row = accuracies(crossing_courses([found]), fleet=False).groups[0].rows[0]
        passed_at, last = row.cells[0], row.cells[-1]
        assert isinstance(passed_at, Value)
        assert spaced(passed_at.spread) == f"{crossed_at - 20:.0f} to {crossed_at + 100:.0f} h"
        assert spaced(str(last)) == cell
        # What is scored stays.
        scored, again = (
            backtest_json(result(one))["pooled"]["crossings"] for one in (exact, found)
        )
        assert scored == again
        told_by = backtest_json(result(found))["drives"][0]["origins"][0]["forecasts"][0]
        assert told_by["passed_between_hours"] == [crossed_at - 20, crossed_at + 100]
    assert "Where wear speeds up, that is before" in method(result(found))[1].text


@pytest.mark.parametrize(
    ("crossed_at", "tests", "told"),
    [
        (380.0, (300.0, 390.0), "too late."),
        (380.0, (300.0, 450.0), "by less than the tests tell."),
        (640.0, (560.0, 700.0), "by less than the tests tell."),
        (640.0, (620.0, 700.0), "too early."),
    ],
)
def test_the_side_of_a_miss_is_told_where_the_tests_know_it(
    crossed_at: float, tests: tuple[float, float], told: str
) -> None:
    made = drive("d", crossed_at)
    score = replace(made.origins[0].crossings[0], from_truth=False, passed_between=tests)
    made = replace(made, origins=(replace(made.origins[0], crossings=(score,)),))
    with house_style():
        found = forecast_intervals(made)
    assert found is not None
    assert spaced(found.alt) == f"1 forecast of d: it misses what came later, {told}"


def test_the_report_draws_hits_and_misses() -> None:
    found = result(drive("d1", 500.0), drive("d2", 900.0), drive("d3", math.inf))
    page = Page(build_backtest_report(found))
    assert page.faults == []
    alts = [spaced(picture["alt"] or "") for picture in page.pictures]
    assert alts[:3] == [
        "1 forecast of d1: it holds what came later in its 90 % interval.",
        "1 forecast of d2: it misses what came later, too early.",
        "1 forecast of d3: it misses what came later, too early.",
    ]
    assert len(alts) == 6
    assert "1 of 2 forecasts put more than even odds within 20 %" in alts[5]
    assert len(page.captions) == 6
    # Each picture has its numbers under names of their own.
    files = [attributes for _, attributes in page.tags if "download" in attributes]
    assert [attributes["download"] for attributes in files] == [
        "forecasts-d1.csv",
        "forecasts-d2.csv",
        "forecasts-d3.csv",
        "coverage.csv",
        "where-what-came-fell.csv",
        "remaining-life-over-life.csv",
    ]
    [head, missed] = read(str(files[1]["href"]))
    assert dict(zip(head, missed, strict=True))["passed at [h]"] == "900"
    assert read(str(files[2]["href"]))[1][-2:] == ["", "5000"]
    [head, *rows] = read(str(files[5]["href"]))
    assert [row[0] for row in rows] == ["d1", "d2"]
    assert dict(zip(head, rows[1], strict=True))["true remaining life"] == "1"
    # Each crossing is said to be whose, as forecasts are: by folder, as ids may be alike.
    assert "d1: Lost motion" in page.text
    assert "d2: Lost motion" in page.text
    alone = result(replace(drive("d1", 500.0), drive_id="same"), drive("d3", math.inf))
    assert "d1: Lost motion" in Page(build_backtest_report(alone)).text
    # A crossing that the horizon cut off counts against the interval that ended before it.
    assert "1 held what came (for 1 that the limit was not passed)" in page.text


def test_an_interval_that_is_out_of_line_is_named() -> None:
    """The 90 % interval holds what it should, the 50 % interval does not."""
    name = "next test's figures"
    rows = [
        CoverageRow(name, Coverage(0.5, 22, 27, 0.5), judged=True),
        CoverageRow(name, Coverage(0.9, 26, 27, 0.9), judged=True),
    ]
    told = spaced(coverage(rows).alt)
    assert told.endswith("; out of line: the 50 % intervals of next test's figures.")


def test_the_json_is_strict_and_whole() -> None:
    found = backtest_json(result(drive("d1", 500.0), drive("d3", math.inf)))
    again = json.loads(json.dumps(found, allow_nan=False))
    pooled = again["pooled"]["crossings"]
    assert (pooled["forecasts"], pooled["distinct"], pooled["crossing_seen"]) == (2, 2, 1)
    wide = pooled["coverage"][1]
    assert (wide["nominal"], wide["held"], wide["forecasts"]) == (0.9, 1, 2)
    assert wide["expected_share"] == pytest.approx(0.9)
    assert again["pooled"]["next_tests"]["figures"][0]["ratio"] == pytest.approx(0.5)
    forecast = again["drives"][1]["origins"][0]["forecasts"][0]
    assert forecast["crossed_at_hours"] is None
    assert forecast["forecast_hours"]["q50"] == pytest.approx(500.0)


def test_a_median_past_the_horizon_has_no_number_in_the_json() -> None:
    late = drive("d1", 500.0)
    score = replace(late.origins[0].crossings[0], late_hours=None, accuracy=None)
    late = replace(late, origins=(replace(late.origins[0], crossings=(score,)),))
    again = json.loads(json.dumps(backtest_json(result(late)), allow_nan=False))
    for found in (again["pooled"]["crossings"], again["drives"][0]):
        assert found["late_share"] is None
        assert found["late_past_horizon"] is True
    assert "past the horizon" in words(late)
    usual = backtest_json(result(drive("d1", 480.0)))["drives"][0]
    assert usual["late_share"] == pytest.approx(20 / 480)
    assert usual["late_past_horizon"] is False


@pytest.mark.parametrize(
    ("late", "text", "accuracy"),
    [
        (None, "past the horizon", "0.90 of 1 forecast"),
        (20.0, "20 h late", "0.90"),
        (-20.0, "20 h early", "0.90"),
        (0.0, "on time", "0.90"),
    ],
)
def test_the_last_forecast_is_the_last_one(late: float | None, text: str, accuracy: str) -> None:
    first = drive("d1", 480.0).origins[0].crossings[0]
    course = CrossingCourse(
        "d1",
        LOST.key,
        0.0,
        480.0,
        (0.0, 200.0),
        (first, replace(first, late_hours=late, accuracy=None if late is None else 0.9)),
        None,
        0.9,
    )
    cells = accuracies([course], fleet=False).groups[0].rows[0].cells
    assert [spaced(str(cell)) for cell in cells[-2:]] == [accuracy, text]


def test_a_limit_that_is_crossed_again_is_titled_with_every_crossing() -> None:
    first, second = origin("t01", 0.0, 500.0), origin("t02", 700.0, 1200.0)
    after, third = origin("t03", 1300.0, math.inf), origin("t04", 1300.0, 1800.0)

    def title(*origins: OriginScores) -> str:
        return spaced(_passed([(one, one.crossings[0]) for one in origins]))

    assert title(first) == ": passed at 500 h"
    assert title(after) == ": not passed by 5 000 h"
    assert title(first, second) == ": passed at 500 h and 1 200 h"
    assert title(first, second, after) == (": passed at 500 h and 1 200 h, not again by 5 000 h")
    assert title(first, second, third) == ": passed 3 times, last at 1 800 h"


def test_dollar_signs_in_the_name_of_a_test_are_no_formula() -> None:
    found = drive("d1", 500.0)
    named = replace(found.origins[0], test_id="$\\frac{t$")
    assert Page(build_backtest_report(result(replace(found, origins=(named,))))).faults == []
