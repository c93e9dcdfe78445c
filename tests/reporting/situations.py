"""The situations that a report has to put into words, each with the name of its golden file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache

from hdprog.reporting.build import build_report
from hdprog.results import DriveResult
from tests.reporting import drives, explanations

SITUATIONS: Mapping[str, Callable[[], DriveResult]] = {
    "healthy": lambda: _read_off(drives.healthy()),
    "inspect-by": lambda: drives.wearing(drives.LOST_MOTION, drives.SECANT),
    "past-the-limit": drives.past_limit,
    "not-enough-data": lambda: drives.wearing(count=1, now=100.0, crossing=6000.0, spread=1500.0),
    "not-converged": drives.not_converged,
    "effect-found": explanations.of_drive,
    "unexplained": lambda: _read_off(
        explanations.single(explanations.unexplained()), "lost_motion_arcmin"
    ),
}


def _read_off(result: DriveResult, missed: str = "") -> DriveResult:
    return replace(result, tests=tuple(drives.read_off(test, missed) for test in result.tests))


@cache
def report_of(name: str) -> str:
    """The report of a situation, made once for all the tests that look at it."""
    return build_report(SITUATIONS[name]())
