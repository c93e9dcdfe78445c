"""A leap between two tests is asked about; smooth wear hardly ever is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.reporting.leap_words import leap_words, leaps
from hdprog.reporting.trend_words import trend_warnings
from hdprog.results import DriveResult, FigureTrend
from tests.independent.drives import REGULAR_LAWS, random_wear
from tests.reporting import drives
from tests.reporting.page import spaced

HOURS = np.array([0.0, 950.0, 2090.0, 3430.0, 4050.0, 5420.0, 6340.0, 7660.0])
LEAPT = np.array([0.417, 0.523, 0.637, 0.760, 1.095, 1.193, 1.270, 1.364])
SD = np.full(8, 0.009)


def test_a_leap_is_found_in_its_stretch() -> None:
    assert leaps(HOURS, LEAPT, SD) == [3]
    assert leaps(HOURS, LEAPT, 10 * SD) == []
    assert leaps(HOURS[:4], LEAPT[:4], SD[:4]) == []
    assert leaps(np.where(HOURS > 6000, 6000.0, HOURS), LEAPT, SD) == []
    running_in = np.array([0.0, 0.5, 0.6, 0.7, 0.75, 0.85, 0.9, 1.0])
    assert leaps(HOURS, running_in, SD) == []


@pytest.mark.parametrize("shape", [1.0, 0.5, 2.0, 3.0])
def test_powers_of_the_hours_are_no_leaps(shape: float) -> None:
    assert leaps(HOURS, (HOURS / 7660.0) ** shape, SD) == []


def test_smooth_lives_are_hardly_ever_asked_about() -> None:
    """24 lives that wear by a power of the hours or towards an end, six plans of tests each.

    One in a hundred asks in the long run; six or more of 144 come by chance in one of 400.
    """
    rng = np.random.default_rng(3)
    asked = 0
    for number in range(24):
        life = random_wear(
            rng, REGULAR_LAWS[number % len(REGULAR_LAWS)], one_course=True, drift=0.07
        )
        for _ in range(6):
            gaps = rng.gamma(2.5, size=7)
            last = rng.uniform(0.5, 0.8) * life.hours[-1]
            hours = np.append(0.0, np.cumsum(gaps) / gaps.sum()) * last
            values = np.interp(hours, life.hours, life.figures["lost_motion_arcmin"])
            values *= np.exp(0.012 * rng.standard_normal(8))
            asked += bool(leaps(hours, values, 0.005 * values))
    assert asked < 6


def leapt() -> DriveResult:
    """Eight tests of a drive with a limit on its lost motion, the figure as in `LEAPT`."""
    result = drives.wearing(drives.LOST_MOTION, count=8)
    assert result.trend is not None
    course = result.trend.figures[drives.LOST_MOTION.key]
    levels = LEAPT + np.linspace(-1.645, 1.645, 5)[:, None] * SD
    own = FigureTrend(course.key, course.hours, course.quantiles, HOURS, levels)
    tests = [replace(one, service_hours=at) for one, at in zip(result.tests, HOURS, strict=True)]
    trend = replace(result.trend, figures={course.key: own})
    return replace(result, tests=tuple(tests), trend=trend)


def test_what_happened_is_asked_where_no_event_says_it() -> None:
    result = leapt()
    assert result.trend is not None
    (course,) = result.trend.figures.values()
    (said,) = leap_words(course, result.tests)
    assert said in trend_warnings(result.trend, result.tests)
    assert spaced(said).startswith(
        "Lost motion leapt from 0.760 to 1.10 arcmin between tests t04 (3 430 h) and t05 (4 050 h)"
    )
    *before, fifth, sixth, seventh, eighth = result.tests
    declared = replace(fifth, event="reassembled")
    assert leap_words(course, [*before, declared, sixth, seventh, eighth]) == []
