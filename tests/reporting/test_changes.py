"""What changed since the test before, in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hdprog.explanation import DriveExplanation
from hdprog.reporting.sections.changes import changes
from hdprog.results import DriveResult
from tests.reporting.drives import LOST_MOTION, wearing
from tests.reporting.explanations import of_drive

_OTHER_WAY = "The trend over all tests goes the other way in lost motion"


def text(result: DriveResult) -> str:
    found = changes(result)
    assert found is not None
    return found.text


def test_a_change_along_the_trend_is_told_and_no_more() -> None:
    said = text(wearing(LOST_MOTION, crossing=600.0, now=900.0, count=3))
    assert "lost motion has risen" in said
    assert _OTHER_WAY not in said


def test_a_change_against_the_trend_says_so() -> None:
    """The last two tests trade their figures; the trend stays."""
    result = wearing(LOST_MOTION, crossing=600.0, now=900.0, count=3)
    first, before, now = result.tests
    swapped = (
        first,
        replace(before, figures=now.figures),
        replace(now, figures=before.figures),
    )
    said = text(replace(result, tests=swapped))
    assert "lost motion has fallen" in said
    assert _OTHER_WAY in said
    assert _OTHER_WAY not in text(replace(result, tests=swapped, trend=None))


def test_figures_that_stand_still_go_against_no_trend() -> None:
    result = wearing(LOST_MOTION, crossing=600.0, now=900.0, count=3)
    first, before, now = result.tests
    said = text(replace(result, tests=(first, now, replace(now, test_id=before.test_id))))
    assert "none of the figures that matter here has moved" in said
    assert _OTHER_WAY not in said


def test_what_wear_has_brought_counts_as_in_the_trend() -> None:
    result = wearing(LOST_MOTION, crossing=600.0, now=900.0, count=3)
    assert result.trend is not None
    first, before, now = result.tests
    same = replace(now, figures=before.figures)
    key = LOST_MOTION.key
    grown = {key: {level: 2.0 * value for level, value in before.figures[key].items()}}
    tests = (first, before, replace(same, figures_with_effects=grown))
    alone = replace(result, tests=tests)
    assert "lost motion has risen" not in text(alone)
    with_it = replace(alone, trend=replace(result.trend, followed=("backlash",)))
    assert "lost motion has risen" in text(with_it)
    found = changes(with_it)
    assert found is not None
    assert "count backlash in, as the trend does" in found.table.caption


def test_an_effect_that_a_test_cannot_show_has_neither_come_nor_gone() -> None:
    result = of_drive()
    *_, before, now = result.tests
    explanation = result.explanation
    assert isinstance(explanation, DriveExplanation)
    first = replace(result, tests=(replace(before, effects=("backlash",)), now))
    last = replace(result, tests=(before, replace(now, effects=("backlash",))))
    assert "Effects that only the test before had: backlash." in text(first)
    assert "Effects that the test before did not have: backlash." in text(last)
    explanation.amplitudes["backlash"][-2:, 1:] = np.nan
    assert "Test t07 cannot show backlash, which test t06 has." in text(first)
    assert "Test t06 cannot show backlash, which test t07 has." in text(last)
    assert "Effects that" not in text(first) + text(last)
