"""Limits that a figure has gone away from, test after test: above and below confused, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hdprog.config import Limit
from hdprog.reporting.bias import deviation
from hdprog.reporting.words import capital, quantity, threshold_words
from hdprog.results import DriveResult, TestResult, since_replaced

_TESTS = 3  # of two, one may have been mounted otherwise
_SURELY = 5.0  # standard deviations of the first and the last test together
_MUCH = 0.05  # of the figure: less may be remounting


def limits_left_behind(result: DriveResult) -> list[str]:
    """Sentences on figures that wear takes away from their only limit.

    A limit on that side is never passed, however worn the drive. Steps by an event are no wear.
    """
    tests, limits = since_replaced(result.tests), result.drive.limits
    worn = len({test.service_hours for test in tests}) >= _TESTS
    if not worn or any(test.event for test in tests[1:]):
        return []
    return [
        f"{capital(quantity(limit.key).name)} has gone away from its limit since the first test: "
        f"{limit.direction} {threshold_words(limit.key, limit.threshold)} does not guard the side "
        "that wear takes it to. Check “above” and “below” in drive.toml."
        for limit in limits
        if _one_sided(limit, limits) and _gone_away(tests, limit)
    ]


def _one_sided(limit: Limit, limits: Sequence[Limit]) -> bool:
    return all(other.direction == limit.direction for other in limits if other.key == limit.key)


def _gone_away(tests: Sequence[TestResult], limit: Limit) -> bool:
    seen = [test.figures[limit.key] for test in tests if limit.key in test.figures]
    if len(seen) < _TESTS:
        return False
    first, last = seen[0], seen[-1]
    away = (first[0.50] - last[0.50]) * (1.0 if limit.direction == "above" else -1.0)
    spread = math.hypot(deviation(first), deviation(last))
    return away > max(_SURELY * spread, _MUCH * abs(first[0.50]))
