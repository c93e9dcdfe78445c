"""A figure that leapt between two tests, where no event says what happened, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.physics.parameters import FloatArray
from hdprog.reporting.bias import deviation
from hdprog.reporting.rounding import hours, significant
from hdprog.reporting.words import capital, quantity, with_unit
from hdprog.results import LEVELS, FigureTrend, TestResult, since_replaced

_FEWEST_TESTS = 5
_STEP, _PACE = 2.0, 3.0  # times the largest of the others; see `leaps`
_SEEN = 6.0  # standard deviations of the step


def leap_words(course: FigureTrend, tests: Sequence[TestResult]) -> list[str]:
    """Ask what happened where a limited figure leapt towards its limit."""
    own = since_replaced(tests)
    first = len(tests) - len(own)
    levels = dict(zip(LEVELS, course.test_quantiles[:, first:], strict=True))
    medians, sd = levels[0.50], deviation(levels)
    signs = {"above": 1.0, "below": -1.0}
    towards = {signs[one.direction] for one in own[-1].drive.limits if one.key == course.key}
    found = {at for sign in towards for at in leaps(course.test_hours[first:], sign * medians, sd)}
    return [
        _asked(course.key, own[at : at + 2], medians[at : at + 2])
        for at in sorted(found)
        if own[at + 1].event is None
    ]


def leaps(at: FloatArray, values: FloatArray, sd: FloatArray) -> list[int]:
    """Stretches between tests, by the number of the first, in which a rising value leapt.

    By more than twice what any other stretch brought, at more than three times the pace of any
    other but the first, in which drives run in, and by six standard deviations. Of simulated lives
    of smooth wear about one in a hundred is told so, of wear in random steps (a gamma process) one
    in twenty.

    Parameters
    ----------
    at, values, sd : (tests,) service hours, value and its standard deviation
    """
    step, passed = np.diff(values), np.diff(at)
    if at.size < _FEWEST_TESTS or not (passed > 0).all():
        return []
    pace = step / passed
    return [
        stretch
        for stretch in range(1, step.size)
        if step[stretch] > _STEP * max(np.delete(step, stretch).max(), 0.0)
        and pace[stretch] > _PACE * max(np.delete(pace, [0, stretch]).max(), 0.0)
        and step[stretch] > _SEEN * np.hypot(sd[stretch], sd[stretch + 1])
    ]


def _asked(key: str, ends: Sequence[TestResult], values: FloatArray) -> str:
    named = quantity(key)
    before, after = (significant(named.factor * value) for value in values)
    since, until = (hours(test.service_hours or 0.0) for test in ends)
    return (
        f"{capital(named.name)} leapt from {before} to {with_unit(after, named.unit)} between "
        f"tests {ends[0].test_id} ({since}) and {ends[1].test_id} ({until}), where no event is "
        "declared, and hardly moved otherwise. Look for what happened there (an overload, a shock, "
        "work on the joint): the trend takes it for wear."
    )
