"""A report in the units that its reader wants; the numbers inside stay as they are."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from hdprog.config import ReportSettings, drive_from_mapping
from hdprog.errors import BadInputError
from hdprog.reporting.build import build_report
from hdprog.reporting.fleet_words import fleet_entry
from hdprog.reporting.reader_units import loop_angle, shown, shown_in
from hdprog.reporting.sections.paper_method import paper_method
from hdprog.reporting.sections.table import Cell, Value
from hdprog.reporting.summary import summary_json
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult, NotReproduced, PaperIdentification
from tests.reporting import drives, explanations
from tests.reporting.page import Page, spaced

POUNDS = ReportSettings("mrad", "in·lbf")


def told_in(result: DriveResult, settings: ReportSettings) -> DriveResult:
    return replace(result, drive=replace(result.drive, report=settings))


@pytest.mark.parametrize(
    ("unit", "factor", "name"),
    [
        ("arcmin", 0.2908882, "mrad"),
        ("Nm", 8.850746, "in·lbf"),
        ("Nm/rad", 8.850746, "in·lbf/rad"),
        ("Nm/s", 8.850746, "in·lbf/s"),
        ("rad/Nm", 1 / 8.850746, "rad/in·lbf"),
        ("1/rad", 1.0, "1/rad"),
        ("J", 1.0, "J"),
        ("µrad", 1.0, "µrad"),
    ],
)
def test_units_are_converted(unit: str, factor: float, name: str) -> None:
    with shown_in(POUNDS):
        found = shown(unit)
    assert found.factor == pytest.approx(factor, rel=1e-6)
    assert found.unit == name
    assert shown(unit).factor == 1.0
    assert shown(unit).unit == unit


def test_a_loops_angle_is_rad_inside() -> None:
    assert loop_angle().factor == pytest.approx(3437.7468, rel=1e-7)
    with shown_in(ReportSettings("rad", "Nm")):
        assert loop_angle().factor == 1.0


def test_no_other_unit_of_angle_or_torque_is_left_on_the_page() -> None:
    for result in (
        drives.wearing(drives.LOST_MOTION, drives.SECANT, count=3),
        explanations.single(explanations.unexplained()),
    ):
        page = Page(build_report(told_in(result, POUNDS), {"K1_Nm_per_rad": 3.1e4}))
        alts = " ".join(str(picture["alt"]) for picture in page.pictures)
        assert re.findall(r".{30}\b(?:arcmin|Nm)\b", f"{page.text} {alts}") == []
        assert "in·lbf/rad" in page.text
        files = [str(a["href"]) for tag, a in page.tags if "download" in a]
        assert files
        assert not any("[arcmin]" in file or "[Nm" in file for file in files)


def test_limits_and_values_are_converted_alike() -> None:
    result = drives.past_limit()
    said = [spaced(verdict(told_in(result, s)).sentences[0]) for s in (ReportSettings(), POUNDS)]
    numbers = [[float(n) for n in re.findall(r"\d+\.?\d*", text)[:2]] for text in said]
    assert "0.5818 mrad" in said[1]
    assert numbers[1][1] / numbers[0][1] == pytest.approx(0.29089, rel=0.01)


def test_the_summary_keeps_its_units_and_names_the_readers() -> None:
    result = drives.wearing(drives.LOST_MOTION, drives.SECANT, count=3)
    usual, told = summary_json(result), summary_json(told_in(result, POUNDS))
    for key in ("tests", "trend", "forecast", "units"):
        assert usual[key] == told[key]
    assert told["report"] == {"angle_unit": "mrad", "torque_unit": "in·lbf"}
    course, own = fleet_entry(usual).course, fleet_entry(told).course
    assert course is not None
    assert own is not None
    assert (course.unit, own.unit) == ("arcmin", "mrad")
    assert own.limit / course.limit == pytest.approx(0.2908882, rel=1e-6)


def test_sentences_of_the_summary_have_the_readers_units() -> None:
    """As its verdict has, which stands beside them."""
    result = drives.wearing(drives.LOST_MOTION, count=3)
    assert result.trend is not None
    seen = NotReproduced(drives.LOST_MOTION.key, (1,), 1, (0.9, 1.0, 1.1), (1.9, 2.0, 2.1))
    far = replace(drives.SECANT, at_torque_Nm=90.0)
    drive = replace(result.drive, limits=(*result.drive.limits, far), report=POUNDS)
    trend = replace(result.trend, not_reproduced=(seen,))
    summary = summary_json(replace(result, drive=drive, trend=trend))
    said = " ".join([*summary["trend"]["warnings"], *summary["warnings"]])
    assert "mrad (90 %)" in spaced(said)
    assert "at 797 in·lbf has a limit" in spaced(said)
    assert re.findall(r"\b(?:arcmin|Nm)\b", said) == []


def test_drive_toml_sets_the_units_however_they_are_spelt() -> None:
    content = {"drive": {"id": "x"}, "report": {"angle_unit": "radians", "torque_unit": "lbf in"}}
    assert drive_from_mapping(content).report == ReportSettings("rad", "in·lbf")
    assert drive_from_mapping({"drive": {"id": "x"}}).report == ReportSettings("arcmin", "Nm")


@pytest.mark.parametrize(
    "report", [{"angle_unit": "furlong"}, {"torque_unit": "rad"}, {"angle_unit": "rev"}]
)
def test_a_unit_that_no_report_has_is_refused(report: dict[str, str]) -> None:
    with pytest.raises(BadInputError, match=r"\[report\]: found .* expected one of"):
        drive_from_mapping({"drive": {"id": "x"}, "report": report})


def test_the_papers_own_numbers_are_converted_with_their_units() -> None:
    test = drives.single_fit().tests[0]
    values = {name: one.quantiles[0.5] for name, one in test.parameters.items()}
    found = PaperIdentification(
        points={},
        parameters=values,
        other_choices={name: (value, value) for name, value in values.items()},
        choices_tried=1,
        choices_solved=1,
        threshold_read=10.0,
        by_rule=True,
        rmse_rad=1e-5,
        figures={"lost_motion_arcmin": test.figures["lost_motion_arcmin"][0.5]},
    )
    told = []
    for settings in (ReportSettings(), POUNDS):
        with shown_in(settings):
            part = paper_method(replace(test, paper=found))
        assert part is not None
        told.append({row.head: row for group in part.table.groups for row in group.rows})
    for head, factor, unit in (("K_F", 8.850746, "in·lbf/rad"), ("Lost motion", 0.29089, "mrad")):
        usual, own = told[0][head], told[1][head]
        assert unit in own.note
        assert number(own.cells[0]) / number(usual.cells[0]) == pytest.approx(factor, rel=0.01)
        assert number(own.cells[1]) / number(usual.cells[1]) == pytest.approx(factor, rel=0.02)


def number(cell: Cell) -> float:
    text = cell.text if isinstance(cell, Value) else cell
    return float(text.replace("\u202f", ""))
