"""Tests whose dates or rows tell another order than their service hours, which decide."""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from itertools import pairwise

from hdprog.data.tests_table import DriveTest

__all__ = ["order_doubts"]

_FEWEST_ROWS = 3  # two rows, the newest first, are in an order of their own


def order_doubts(tests: Sequence[DriveTest]) -> Mapping[str, str]:
    """Find tests with more service hours than one of a later date, or of a later row without dates.

    Parameters
    ----------
    tests : sequence of DriveTest
        By service hours.

    Returns
    -------
    mapping of str to str
        Name of the first such test → what contradicts it, in words, and how many more there are. A
        test that contradicts several others counts once.
    """
    dated = [(test, test.date) for test in tests if test.date is not None]
    told: set[str] = set()
    found: list[tuple[str, str]] = []
    for number, (test, date) in enumerate(dated):
        for other, later in reversed(dated[:number]):
            if later <= date or other.service_hours == test.service_hours:
                continue
            if other.test_id not in told:
                found.append((test.test_id, _words(test, date, other, later)))
            told.add(other.test_id)
            break
    if not found:
        return {} if dated else _by_rows(tests)
    (name, words), more = found[0], len(found) - 1
    if more:
        them = "one more test" if more == 1 else f"{more} more tests"
        words += f" Dates and service hours disagree at {them} in the same way."
    return {name: words}


def _by_rows(tests: Sequence[DriveTest]) -> Mapping[str, str]:
    """Find the one place where hours fall from row to row; a table in no order has more of them."""
    rows = sorted(tests, key=lambda test: test.row)
    falls = [
        (above, below)
        for above, below in pairwise(rows)
        if below.service_hours < above.service_hours
    ]
    if len(falls) != 1 or len(rows) < _FEWEST_ROWS:
        return {}
    above, below = falls[0]
    return {
        below.test_id: (
            f"In tests.csv, test {below.test_id} ({below.service_hours:g} h) stands below test "
            f"{above.test_id} ({above.service_hours:g} h), and all other hours rise from row to "
            "row. The hours decide: correct what is wrong there."
        )
    }


def _words(test: DriveTest, date: datetime.date, other: DriveTest, later: datetime.date) -> str:
    return (
        f"By its date, test {test.test_id} ({date}, {test.service_hours:g} h) comes before test "
        f"{other.test_id} ({later}, {other.service_hours:g} h), and by its service hours after "
        "it. The hours decide: correct what is wrong in tests.csv. Where a new drive took its "
        "place in between, let its hours go on from those of the old one, and write replaced as "
        "the event of its first test."
    )
