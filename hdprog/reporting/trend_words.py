"""What a trend warns of, in words and in the reader's units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.physics.parameters import FloatArray
from hdprog.reporting.effect_words import effect_name
from hdprog.reporting.leap_words import leap_words
from hdprog.reporting.rounding import hours
from hdprog.reporting.weak_words import left_to_prior
from hdprog.reporting.words import agree, capital, figure_interval, listed, quantity, with_unit
from hdprog.results import (
    LEVELS,
    FigureTrend,
    NotReproduced,
    SuddenEffect,
    TestResult,
    TrendSummary,
    since_replaced,
)

_MEDIAN = LEVELS.index(0.50)
_ANEW = {
    "regreased": "friction starts anew",
    "reassembled": "preload and friction may step",
}
_REMOUNTED = 0.1  # of a figure: what remounting moves it by is a few hundredths


def trend_warnings(trend: TrendSummary, tests: Sequence[TestResult]) -> list[str]:
    """All warnings of a trend over these tests, by service hours."""
    names = [test.test_id for test in tests]
    found = [*trend.warnings, *(_sudden(one, tests) for one in trend.sudden)]
    found += [_not_reproduced(one, names) for one in trend.not_reproduced]
    for key, course in trend.figures.items():
        off = passed_by(key, course, tests)
        if off:
            found.append(_off_course(key, course, off, names))
        found += leap_words(course, tests)
    return [*found, *_done(tests)]


def _sudden(found: SuddenEffect, tests: Sequence[TestResult]) -> str:
    """Say between which tests an effect came, what that means and what the trend makes of it."""
    ends = [
        test.test_id + ("" if test.service_hours is None else f" ({hours(test.service_hours)})")
        for test in tests[found.test - 1 : found.test + 1]
    ]
    return (
        f"{capital(effect_name(found.effect))} {'came' if found.came else 'went'} at once between "
        f"tests {listed(ends)}, and not with wear: something was changed or broke there. "
        "The trend takes it for a lasting step. Look for what happened; if the drive was taken "
        "apart, declare the event in tests.csv."
    )


def passed_by(key: str, course: FigureTrend, tests: Sequence[TestResult]) -> list[int]:
    """The tests that lie apart from the course by what their own records know.

    Where a record leaves a figure to the prior, the test by itself may lie anywhere.
    """
    return [at for at in off_course(course) if not left_to_prior(tests[at], key)]


def off_course(course: FigureTrend) -> list[int]:
    """The tests that lie apart from the course by more than remounting moves a figure.

    Their 90 % intervals do not meet the course's, and their medians are a tenth of it away. Where
    tests are at the same hours, as before and after regreasing, the course is that after the last.
    """
    at, own = _at_tests(course), course.test_quantiles
    apart = (own[0] > at[-1]) | (own[-1] < at[0])
    far = np.abs(own[_MEDIAN] - at[_MEDIAN]) > _REMOUNTED * np.abs(at[_MEDIAN])
    last = np.append(np.diff(course.test_hours) > 0, True)
    return [int(test) for test in np.flatnonzero(apart & far & last)]


def _at_tests(course: FigureTrend) -> FloatArray:
    """(levels, tests) of the course at the hours of the tests."""
    return np.array([np.interp(course.test_hours, course.hours, row) for row in course.quantiles])


def _off_course(key: str, course: FigureTrend, off: Sequence[int], names: Sequence[str]) -> str:
    figure = quantity(key)
    at = _at_tests(course)
    gap = np.abs(course.test_quantiles[_MEDIAN] - at[_MEDIAN])
    worst = max(off, key=lambda test: gap[test])
    ends = [
        figure_interval(key, *(float(rows[level, worst]) for level in (0, _MEDIAN, -1)))
        for rows in (at, course.test_quantiles)
    ]
    return (
        f"The course of the {figure.name} passes by {agree(len(off), 'test', 'tests')} "
        f"{listed([names[test] for test in off])}: at {names[worst]} it has {ends[0][0]} to "
        f"{with_unit(ends[0][2], figure.unit)} (90 %), and the test by itself {ends[1][0]} to "
        f"{with_unit(ends[1][2], figure.unit)}. Something came at once, or is no wear: do not "
        f"rely on the forecast of {figure.name}."
    )


def _done(tests: Sequence[TestResult]) -> list[str]:
    """Say what was done to the drive that is there now and what that leaves as it is."""
    own, said = since_replaced(tests), []
    for event, anew in _ANEW.items():
        found = [test.test_id for test in own[1:] if test.event == event]
        if found:
            said.append(
                f"The drive was {event} before {agree(len(found), 'test', 'tests')} "
                f"{listed(found)}: {anew} there, and wear goes on."
            )
    return said


def _not_reproduced(one: NotReproduced, names: Sequence[str]) -> str:
    figure = quantity(one.key)
    joint, alone = (figure_interval(one.key, *seen) for seen in (one.joint, one.alone))
    those = f"test{'' if len(one.tests) == 1 else 's'} {listed([names[at] for at in one.tests])}"
    return (
        f"The trend does not reproduce the {figure.name} of {those}: at {names[one.worst]} it has "
        f"{joint[0]} to {with_unit(joint[2], figure.unit)} (90 %), and the test by itself "
        f"{alone[0]} to {with_unit(alone[2], figure.unit)}. Read the forecast of {figure.name} "
        "with care."
    )
