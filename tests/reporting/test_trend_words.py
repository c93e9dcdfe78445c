"""What a trend warns of, as the reader gets it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hdprog.config import Limit, ReportSettings
from hdprog.reporting.json_of_trend import trend_json
from hdprog.reporting.reader_units import shown_in
from hdprog.reporting.trend_words import off_course, trend_warnings
from hdprog.reporting.verdict import verdict
from hdprog.results import LEVELS, DriveResult, NotReproduced, Sensitivity, SuddenEffect
from tests.reporting.drives import wearing
from tests.reporting.test_weak_words import SETTLED

FOUND = NotReproduced(
    "hysteresis_width_arcmin", (0, 1), 1, (0.412, 0.44, 0.468), (0.52, 0.561, 0.602)
)


def plain(text: str) -> str:
    """With ordinary spaces."""
    return " ".join(text.split())


def test_a_figure_that_is_not_reproduced_is_told_with_its_tests_and_units() -> None:
    result = wearing()
    assert result.trend is not None
    trend = replace(result.trend, warnings=("first",), not_reproduced=(FOUND,))
    names = [test.test_id for test in result.tests]
    first, said = (plain(text) for text in trend_warnings(trend, result.tests))
    assert first == "first"
    assert said == (
        f"The trend does not reproduce the hysteresis width of tests {names[0]} and {names[1]}: "
        f"at {names[1]} it has 0.41 to 0.47 arcmin (90 %), and the test by itself 0.52 to "
        "0.60 arcmin. Read the forecast of hysteresis width with care."
    )
    with shown_in(ReportSettings(angle_unit="mrad")):
        assert "0.120 to 0.136 mrad (90 %)" in plain(trend_warnings(trend, result.tests)[1])


def test_one_test_is_named_by_itself() -> None:
    result = wearing()
    assert result.trend is not None
    trend = replace(result.trend, not_reproduced=(replace(FOUND, tests=(1,)),))
    assert f"of test {result.tests[1].test_id}: at" in trend_warnings(trend, result.tests)[-1]


def passing_by() -> DriveResult:
    """A drive whose course has two thirds more than its third test."""
    result = wearing(count=6)
    assert result.trend is not None
    (key,) = result.trend.figures
    course = result.trend.figures[key]
    moved = course.test_quantiles.copy()
    moved[:, 2] *= 0.6
    figures = {key: replace(course, test_quantiles=moved)}
    return replace(result, trend=replace(result.trend, figures=figures))


def test_tests_that_the_course_passes_by_are_named() -> None:
    """An effect that came at once: the course goes half-way between before and after."""
    straight, result = wearing(count=6), passing_by()
    assert straight.trend is not None
    assert result.trend is not None
    (key,) = result.trend.figures
    course, bent, trend = straight.trend.figures[key], result.trend.figures[key], result.trend
    assert off_course(course) == []
    assert off_course(bent) == [2]
    (said,) = [text for text in trend_warnings(trend, result.tests) if "passes by" in text]
    assert "passes by test t03" in said
    assert "do not rely on the forecast of lost motion" in said


def test_a_test_whose_record_leaves_the_figure_to_the_prior_is_not_passed_by() -> None:
    """A preload that the record did not tell was said to have come at once."""
    result = passing_by()
    assert result.trend is not None
    (key,) = result.trend.figures
    course = result.trend.figures[key]
    wide = dict(zip(LEVELS, (1.0, 1.3, 1.5, 1.7, 2.0), strict=True))

    def told(index: int, figure: str, **known: object) -> tuple[bool, bool]:
        tests = list(result.tests)
        changed = replace(tests[index], **known)  # type: ignore[arg-type]
        tests[index] = replace(changed, figures={**changed.figures, figure: wide})
        trend = replace(result.trend, figures={figure: course})
        drive = replace(result.drive, limits=(Limit(figure, 1.0, "above"),))
        other = replace(result, drive=drive, tests=tuple(tests), trend=trend)
        warned = any("passes by" in text for text in trend_warnings(trend, tests))
        return warned, any("passes by" in text for text in verdict(other).sentences)

    leans, rests = Sensitivity(0.26, 0.11, "shared"), Sensitivity(0.02, 0.5, "record")
    beyond = replace(SETTLED, beyond_record=0.998)
    assert told(2, key, sensitivity={key: rests}) == (True, True)
    assert told(2, key, sensitivity={key: leans}) == (False, False)
    assert told(1, key, sensitivity={key: leans}) == (True, True)  # of another test
    assert told(2, key, identification=beyond) == (True, True)  # which is of the preload alone
    assert told(2, "preload_Nm", identification=beyond) == (False, False)
    assert told(2, "preload_Nm", identification=SETTLED) == (True, True)


def test_an_effect_that_came_at_once_is_told_with_its_tests_hours_and_what_to_do() -> None:
    result = wearing(count=7)
    assert result.trend is not None
    trend = replace(result.trend, sudden=(SuddenEffect("coulomb_friction", 3, True),))
    (said,) = [plain(text) for text in trend_warnings(trend, result.tests) if "at once" in text]
    assert said.startswith(
        "Coulomb friction came at once between tests t03 (300 h) and t04 (450 h), and not with "
        "wear: something was changed or broke there."
    )
    assert "declare the event in tests.csv" in said
    (found,) = trend_json(trend, result.tests)["sudden_effects"]
    assert found == {
        "effect": "coulomb_friction",
        "between_tests": ["t03", "t04"],
        "came": True,
    }
    gone = replace(result.trend, sudden=(SuddenEffect("backlash", 3, False),))
    assert any(text.startswith("Backlash went at") for text in trend_warnings(gone, result.tests))
    assert trend_json(result.trend, result.tests)["sudden_effects"] == []


@pytest.mark.parametrize(
    ("event", "anew"),
    [("regreased", "friction starts anew"), ("reassembled", "preload and friction may step")],
)
def test_what_was_done_to_the_drive_is_told(event: str, anew: str) -> None:
    result = wearing(count=4)
    assert result.trend is not None
    tests = [
        replace(test, event=event if at == 2 else None) for at, test in enumerate(result.tests)
    ]
    (said,) = [text for text in trend_warnings(result.trend, tests) if event in text]
    assert said == f"The drive was {event} before test t03: {anew} there, and wear goes on."
    # Of a drive that is there no more nothing goes on.
    tests[3] = replace(tests[3], event="replaced")
    assert not [text for text in trend_warnings(result.trend, tests) if event in text]


def test_the_verdict_says_that_the_course_passes_tests_by() -> None:
    said = " ".join(verdict(passing_by()).sentences)
    assert "The trend passes by some tests of lost motion: read the warnings" in said
    assert "passes by" not in " ".join(verdict(wearing(count=6)).sentences)


def test_a_test_before_what_was_done_at_the_same_hours_is_not_passed_by() -> None:
    """The course at these hours is that after regreasing."""
    trend = passing_by().trend
    assert trend is not None
    (course,) = trend.figures.values()
    hours = course.test_hours.copy()
    hours[2] = hours[3]
    assert off_course(replace(course, test_hours=hours)) == []
