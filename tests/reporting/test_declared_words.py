"""Limits and shutdowns that tests and forecast do not reach are told, in the report and in JSON."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hdprog.config import Limit
from hdprog.reporting.declared_words import declared_words
from hdprog.reporting.far_limits import far_words
from hdprog.reporting.fleet_words import fleet_entry
from hdprog.reporting.sections.warnings import warnings
from hdprog.reporting.summary import summary_json
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives
from tests.reporting.page import spaced


def said(result: DriveResult) -> list[str]:
    found = declared_words(result)
    assert all(text in warnings(result) for text in found)
    assert [spaced(text) for text in summary_json(result)["warnings"]] == [*map(spaced, found)]
    return [spaced(text) for text in found]


def test_another_ratio_than_the_models() -> None:
    result = drives.single_fit()
    result = replace(result, drive=replace(result.drive, model="CSF-25-80", ratio=100.0))
    (told,) = said(result)
    assert told.startswith("The model CSF-25-80 has the ratio 80, and ratio = 100 is declared")


@pytest.mark.parametrize(("torque", "told"), [(14.0, False), (63.0, False), (500.0, True)])
def test_a_stiffness_beyond_the_recorded_torque(torque: float, told: bool) -> None:
    limit = Limit("secant_stiffness_Nm_per_rad", 1e4, "below", torque)
    result = drives.single_fit()
    result = replace(result, drive=replace(result.drive, limits=(limit,)))
    expected = (
        "Secant stiffness at 500 Nm has a limit, and the tests reach 63 Nm only: beyond that the "
        "model is extrapolated. Load the drive that far, or set the limit at a torque that the "
        "tests reach."
    )
    assert said(result) == ([expected] if told else [])


@pytest.mark.parametrize(("rated", "told"), [(63.0, False), (1600.0, False), (5040.0, True)])
def test_lost_motion_beyond_the_recorded_torque(rated: float, told: bool) -> None:
    """As of a record of the input's torque, which is smaller by the ratio."""
    result = drives.single_fit(drives.LOST_MOTION)
    result = replace(result, drive=replace(result.drive, rated_torque=rated))
    expected = (
        "Lost motion has a limit and is read at ±201.6 Nm, and the tests reach 63 Nm only: beyond "
        "that the model is extrapolated. Load the drive that far, or check that its torque is the "
        "output's, in the unit that is given."
    )
    assert said(result) == ([expected] if told else [])


@pytest.mark.parametrize(
    ("shutdown", "words"),
    [
        (1500.0, None),
        (None, None),
        (800.0, "which is not after the last test at 900 h: no risk is stated by it."),
        (30_000.0, "The next shutdown is given as 30 000 h, past the horizon of 20 000 h: "),
    ],
)
def test_a_shutdown_out_of_sight(shutdown: float | None, words: str | None) -> None:
    found = said(drives.wearing(drives.LOST_MOTION, shutdown=shutdown))
    assert len(found) == (0 if words is None else 1)
    assert words is None or words in found[0]


SECANT, WIDTH = "secant_stiffness_Nm_per_rad", "hysteresis_width_arcmin"


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (Limit(SECANT, 13.0, "below", 14.0), "below 13 Nm/rad, is 1 600 times less than"),
        (Limit(SECANT, 1.3e7, "below", 14.0), "below 13 000 000 Nm/rad, is 410 times more than"),
        (Limit("lost_motion_arcmin", 1e9, "above"), "above 1 000 000 000 arcmin, is "),
        (Limit("preload_Nm", 1.0, "below"), ""),  # all but gone
        (Limit(WIDTH, 0.1, "below"), ""),
        (Limit(SECANT, 10_000.0, "below", 14.0), ""),
    ],
    ids=["in kNm", "as if in mNm", "a slip", "no preload left", "narrow", "usual"],
)
def test_a_limit_far_off_what_the_drive_has_is_told_before_its_risk(
    limit: Limit, words: str
) -> None:
    """13 (kNm/rad) for 13 000 gave "No limit in sight" and no word."""
    result = drives.wearing(limit)
    told = [text for text in map(spaced, verdict(result).sentences) if "check its number" in text]
    assert said(result) == told
    if not words:
        assert told == []
        return
    assert words in told[0]
    assert spaced(verdict(result).sentences[0]) == told[0]
    assert spaced(fleet_entry(summary_json(result)).sentence) == told[0]


def test_a_figure_that_is_0_is_no_limit_passed_but_a_torque_that_is_wrong() -> None:
    limit = Limit("hysteresis_width_arcmin", 0.3, "below")
    assert "never slip" in far_words(limit, 0.0, 0.0, "the test shows")
    assert "more than anything" in far_words(limit, 0.001, 0.002, "the test shows")
    assert far_words(limit, 0.0, 0.4, "the test shows") == ""
