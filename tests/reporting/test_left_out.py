"""Lasting effects that neither forecast nor limits count are told with what they would add."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.explanation import DriveExplanation, Origin
from hdprog.reporting.left_out import gone_sentences
from hdprog.reporting.sections.warnings import warnings
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives, explanations
from tests.reporting.page import spaced

KEY = "lost_motion_arcmin"


def with_play(
    result: DriveResult, added: float, effects: tuple[str, ...] = ("backlash",)
) -> DriveResult:
    """The result, its last test with so much more lost motion in arcmin where play counts."""
    *others, last = result.tests
    seen = {KEY: {level: value + added for level, value in last.figures[KEY].items()}}
    tests = (*others, replace(last, figures_with_effects=seen, effects=effects))
    return replace(result, tests=tests)


def of_drive(origin: Origin, followed: tuple[str, ...] = ()) -> DriveResult:
    found = explanations.drive_explanation(effects=(explanations.backlash(origin=origin),))
    result = explanations.of_drive(found)
    assert result.trend is not None
    return replace(result, trend=replace(result.trend, followed=followed))


def said(result: DriveResult) -> list[str]:
    sentences = [spaced(text) for text in verdict(result).sentences]
    return [text for text in sentences if "from the rig or from wear" in text]


def test_a_drive_whose_play_may_be_wear_is_told_with_it() -> None:
    (found,) = said(with_play(of_drive("unclear"), 1.3))
    assert found.startswith(
        "Backlash comes from the rig or from wear, which these tests do not tell. Forecast and "
        "limits are held against the drive without it; with it lost motion is "
    )
    assert found.endswith("past its limit.")
    assert said(with_play(of_drive("unclear"), 0.5))[0].endswith("inside its limit.")


def test_with_an_alarm_and_a_stop_each_limit_is_named() -> None:
    result = with_play(of_drive("unclear"), 1.3)
    (alarm,) = [one for one in result.drive.limits if one.quantity == "lost_motion_arcmin"]
    drive = replace(result.drive, limits=(alarm, replace(alarm, threshold=5.0)))
    tests = tuple(replace(test, drive=drive) for test in result.tests)
    (found,) = said(replace(result, drive=drive, tests=tests))
    assert "past the limit above 2 arcmin and lost motion is " in found
    assert found.endswith("inside the limit above 5 arcmin.")


@pytest.mark.parametrize(
    "result",
    [
        with_play(of_drive("unclear"), 0.001),
        with_play(of_drive("rig"), 1.3),
        with_play(of_drive("wear", ("backlash",)), 1.3),
        with_play(explanations.of_drive(explanations.adequate_drive()), 1.3),
        with_play(drives.wearing(), 1.3, effects=()),
    ],
    ids=["hardly anything", "the rig", "followed", "nothing found", "nothing sought"],
)
def test_nothing_is_said_where_nothing_is_left_out(result: DriveResult) -> None:
    assert not said(result)


def test_an_effect_of_earlier_tests_is_not_held_against_the_last_ones_figure() -> None:
    result = with_play(of_drive("unclear"), 1.3)
    *others, last = result.tests
    assert not said(replace(result, tests=(*others, replace(last, effects=("microslip",)))))


def test_play_that_the_last_test_cannot_show_is_told_by_the_one_before() -> None:
    """It was passed over without a word, as if it had gone."""
    result = with_play(of_drive("unclear"), 1.3)
    assert isinstance(result.explanation, DriveExplanation)
    sizes = result.explanation.amplitudes["backlash"].copy()
    sizes[-1, 1:] = np.nan
    *others, seen = with_play(replace(result, tests=result.tests[:-1]), 1.3).tests
    blind = replace(result.tests[-1], effects=(), figures_with_effects={})
    (found,) = said(
        replace(
            result,
            tests=(*others, seen, blind),
            explanation=replace(result.explanation, amplitudes={"backlash": sizes}),
        )
    )
    assert f"with it at {seen.test_id}, the last test to show it, lost motion is " in found
    assert found.endswith("past its limit.")


def test_play_that_grows_is_told_where_nothing_is_forecast() -> None:
    result = replace(with_play(of_drive("wear"), 1.3), trend=None, forecasts=())
    sentences = [spaced(text) for text in verdict(result).sentences]
    (found,) = (text for text in sentences if "against the drive without it" in text)
    assert found.startswith("Backlash grows with wear. The limits are held against ")


def test_a_single_record_with_play_is_told_with_it() -> None:
    record = explanations.record("explained", (explanations.backlash(),), "backlash")
    (found,) = said(with_play(explanations.single(record), 1.3))
    assert "The limits are held against the drive without it; with it lost motion is " in found


def test_a_record_fitted_with_play_that_was_asked_for_is_told_with_it() -> None:
    result = with_play(drives.single_fit(drives.LOST_MOTION), 1.3)
    (test,) = result.tests
    assert not said(replace(result, tests=(replace(test, effects=()),)))
    (found,) = said(result)
    assert found.startswith("Backlash comes from the rig or from wear")


def test_what_only_the_replaced_drive_had_is_said_to_be_gone() -> None:
    """Backlash of the old drive stood in the new one's verdict as if it were there."""
    result = explanations.of_drive()
    found = result.explanation
    assert isinstance(found, DriveExplanation)
    sizes = found.amplitudes["backlash"].copy()

    def told(sizes: np.ndarray, event: str | None) -> list[str]:
        tests = (*result.tests[:-1], replace(result.tests[-1], event=event))
        changed = replace(found, amplitudes={"backlash": sizes})
        page = replace(result, tests=tests, explanation=changed)
        assert set(gone_sentences(page)) <= set(warnings(page)) & set(verdict(page).sentences)
        return gone_sentences(page)

    assert told(sizes, "replaced") == []
    sizes[-1, 1:] = 0.0
    assert told(sizes, "replaced") == ["No test since the drive was replaced shows backlash."]
    assert told(sizes, None) == []
    sizes[-1, 1:] = np.nan  # a record that cannot show it
    assert told(sizes, "replaced") == []
