"""Two limits on one side of a figure, an alarm and a stop: each is told by itself, everywhere."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from hdprog.config import Limit
from hdprog.data.truth_file import read_truth
from hdprog.forecast.backtest import score_crossing
from hdprog.forecast.backtest_pool import crossing_courses, distinct_crossings
from hdprog.forecast.crossing import Crossing
from hdprog.reporting.backtest_json import backtest_json
from hdprog.reporting.build import build_report
from hdprog.reporting.figures.backtest_intervals import forecast_intervals
from hdprog.reporting.figures.service_life import life_picture, trend_pictures
from hdprog.reporting.sections.backtest import accuracies
from hdprog.reporting.sections.remaining_life import limits_table
from hdprog.reporting.style import house_style
from hdprog.reporting.summary import summary_json
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives
from tests.reporting.page import spaced
from tests.reporting.test_backtest import drive as backtest_of
from tests.reporting.test_backtest import result as pool

ALARM, STOP = drives.LOST_MOTION, replace(drives.LOST_MOTION, threshold=5.0)
NOW = 900.0


def worn(alarm_at: float, stop_at: float) -> DriveResult:
    """A drive that passes the two about these hours."""
    result = drives.wearing(ALARM, STOP)
    spread = 30.0 * np.random.default_rng(2).standard_normal(4000)
    hours = [np.maximum(at + spread, NOW) for at in (alarm_at, stop_at)]
    told = [
        drives.forecast_of(limit, at, NOW)
        for limit, at in zip((ALARM, STOP, None), (*hours, hours[0]), strict=True)
    ]
    return replace(result, forecasts=tuple(told))


def test_the_verdict_tells_the_alarm_that_is_passed_and_the_stop_to_come() -> None:
    said = [spaced(text) for text in verdict(worn(700.0, 1900.0)).sentences]
    assert said[0].startswith("Lost motion is past its limit: above 2 arcmin;")
    assert said[1] == "Inspect now."
    assert said[2].startswith("Lost motion is forecast to pass 5 arcmin between 1 8")
    ahead = spaced(verdict(worn(1500.0, 2500.0)).text)
    assert "The first limit (most likely lost motion above 2 arcmin)" in ahead


def test_each_has_its_forecast_in_json_and_in_the_table() -> None:
    result = worn(1500.0, 2500.0)
    told = summary_json(result)["forecast"]
    assert [(one["quantity"], one["limit"], one["direction"]) for one in told] == [
        ("lost_motion_arcmin", 2.0, "above"),
        ("lost_motion_arcmin", 5.0, "above"),
        ("first_limit", None, None),
    ]
    medians = [one["remaining_hours"]["q50"] for one in told]
    assert 500.0 < medians[0] < 700.0 < 1500.0 < medians[1]
    rows = [row for group in limits_table(result).groups for row in group.rows]
    heads = [spaced(row.head) for row in rows]
    assert heads == ["Lost motion above 2 arcmin", "Lost motion above 5 arcmin", "first of all"]


def test_each_has_its_picture_and_a_file_of_its_own() -> None:
    result = worn(1500.0, 2500.0)
    with house_style():
        life, drawn = life_picture(result), trend_pictures(result)
    assert life is not None
    assert life.data is not None
    assert {"lost motion above 2 arcmin", "lost motion above 5 arcmin"} <= set(life.data.columns)
    assert [limit for limit, _ in drawn] == [ALARM, STOP]
    assert [found.data and found.data.file for _, found in drawn] == [
        "trend-lost_motion_arcmin-above-2.csv",
        "trend-lost_motion_arcmin-above-5.csv",
    ]
    with house_style():
        ((_, one),) = trend_pictures(drives.wearing(ALARM))
    assert one.data is not None
    assert one.data.file == "trend-lost_motion_arcmin.csv"
    assert "Lost motion above 5" in spaced(build_report(result))


def test_each_is_scored_by_itself_in_a_backtest() -> None:
    drive = backtest_of("d", 500.0)
    (origin,) = drive.origins
    at = np.array([0.0, 1400.0, 1600.0, 5000.0])
    crossing = Crossing(at, np.array([0.0, 0.0, 1.0, 1.0]), already=False, paths=1000)
    stop = score_crossing(STOP, crossing, 1500.0, 5000.0, True, 0.5, 5000.0)
    drive = replace(drive, origins=(replace(origin, crossings=(*origin.crossings, stop)),))
    courses = crossing_courses([drive])
    assert [(course.scores[0].limit, course.crossed_at) for course in courses] == [
        (ALARM, 500.0),
        (STOP, 1500.0),
    ]
    assert distinct_crossings([drive]) == 2
    rows = [row for group in accuracies(courses, fleet=False).groups for row in group.rows]
    heads = [spaced(row.head) for row in rows]
    assert heads == ["Lost motion above 2 arcmin", "Lost motion above 5 arcmin"]
    with house_style():
        assert forecast_intervals(drive) is not None
    (told,) = backtest_json(pool(drive))["drives"]
    assert [one["limit"] for one in told["origins"][0]["forecasts"]] == [2.0, 5.0]


def test_a_truth_that_is_told_by_the_figure_alone_is_of_neither(tmp_path: Path) -> None:
    path = tmp_path / "truth.json"
    both, single = drives.drive(ALARM, STOP), drives.drive(ALARM)
    path.write_text(json.dumps({"crossing_hours": {ALARM.key: 1315.0}}), "utf-8")
    assert read_truth(path, both) is None
    truth = read_truth(path, single)
    assert truth is not None
    assert truth.crossings == {ALARM: 1315.0}
    each = [entry(limit, at) for limit, at in ((ALARM, 1315.0), (STOP, None))]
    path.write_text(json.dumps({"limits": each}), "utf-8")
    truth = read_truth(path, both)
    assert truth is not None
    assert truth.crossings == {ALARM: 1315.0, STOP: float("inf")}


def entry(limit: Limit, crossed_at: float | None) -> dict[str, object]:
    return {
        "quantity": limit.quantity,
        "direction": limit.direction,
        "limit": limit.threshold,
        "crossing_hours": crossed_at,
    }
