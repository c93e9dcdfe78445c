"""What came after an earlier test: later tests' figures, and the crossing of each limit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.config import Limit
from hdprog.data.truth_file import Truth
from hdprog.forecast.limits import room
from hdprog.inference.priors import Prior
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.physics.parameters import FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.summary import own_figures


@dataclass(frozen=True)
class SeenTest:
    """What a test showed of the limited figures.

    Attributes
    ----------
    test_id, service_hours, event : of the test
    figures : (draws,) of the test's own posterior by the limit's key
    temperature_C : of the drive, or None
    """

    test_id: str
    service_hours: float
    event: str | None
    figures: Mapping[str, FloatArray]
    temperature_C: float | None = None

    def median(self, key: str) -> float:
        """Median of a figure."""
        return float(np.median(self.figures[key]))


def seen_test(
    test_id: str,
    test: LoopEvidence,
    limits: Sequence[Limit],
    prior: Prior,
    operation: Operation,
) -> SeenTest:
    """Limited figures of a test from its own posterior."""
    figures = {
        limit.key: own_figures(test, FigureRequest.of(limit), prior, operation) for limit in limits
    }
    return SeenTest(test_id, test.service_hours, test.event, figures, test.temperature_C)


def until_intervention(tests: Sequence[SeenTest]) -> tuple[SeenTest, ...]:
    """Tests up to the first with an event, which no earlier forecast knows of."""
    for number, test in enumerate(tests):
        if test.event is not None:
            return tuple(tests[:number])
    return tuple(tests)


def first_passing(hours: Sequence[float], values: Sequence[float], limit: Limit) -> float:
    """Hour at which straight lines between points first pass a limit; infinite if they do not."""
    left = room(limit, np.asarray(values, dtype=float))
    index = _first_past(left)
    if index is None:
        return math.inf
    if index == 0:
        return float(hours[0])
    share = left[index - 1] / (left[index - 1] - left[index])
    return float(hours[index - 1] + share * (hours[index] - hours[index - 1]))


def _first_past(left: FloatArray) -> int | None:
    past = np.flatnonzero(left <= 0)
    return int(past[0]) if past.size else None


def passed_between(
    limit: Limit, origin: SeenTest, later: Sequence[SeenTest]
) -> tuple[float, float] | None:
    """Service hours of the two tests between which a figure passed a limit.

    That is all that tests tell of the hour: `first_passing` comes before it where wear speeds up,
    and after it where wear slows down. None where the limit was not passed after the origin.
    """
    course = [origin, *later]
    index = _first_past(room(limit, np.array([test.median(limit.key) for test in course])))
    if not index:
        return None
    return course[index - 1].service_hours, course[index].service_hours


def straight_line(hours: Sequence[float], values: Sequence[float], at: float) -> float:
    """Least-squares line through points, read at an hour; the mean where all hours are equal."""
    if len(set(hours)) < 2:
        return float(np.mean(values))
    slope, level = np.polyfit(np.asarray(hours), np.asarray(values), 1)
    return float(level + slope * at)


def what_came(
    limit: Limit,
    origin: SeenTest,
    later: Sequence[SeenTest],
    truth: Truth | None,
    until: float,
) -> tuple[float, float, bool]:
    """What came of a limit after an origin.

    Parameters
    ----------
    limit : which
    origin, later : the last test known, and those after it
    truth : of a simulated drive, used for the limits that it holds
    until : service hours at which the truth ends to be what was forecast: the horizon, or where
        something was done to the drive

    Returns
    -------
    service hours until which something was seen, those of the crossing (infinite if it was not
    seen), and whether this is the truth
    """
    if truth is not None and limit in truth.crossings:
        end, crossed_at = min(truth.known_until, until), truth.crossings[limit]
        return end, crossed_at if crossed_at < end else math.inf, True
    course = [origin, *later]
    hours = [test.service_hours for test in course]
    return hours[-1], first_passing(hours, [t.median(limit.key) for t in course], limit), False
