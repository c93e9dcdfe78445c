"""What the trend takes from each test: its likelihood, never its posterior.

A posterior has the loop's prior in it. Taken as data it would count that prior once a test, and
shrink the trend however many tests are added.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from hdprog.data.tests_table import EVENTS
from hdprog.errors import BadInputError
from hdprog.inference.information import Linearised
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.exact_likelihood import ExactEvidence


class LoopEvidence(Protocol):
    """One test of a drive, as the trend sees it.

    Attributes
    ----------
    service_hours : hours in service at the test
    event : one of `EVENTS`, or None
    load_hours : hours by load since zero (see `wear_clock.hours_by_load`), or None
    temperature_C : of the drive, or None
    posterior : (draws, n) drawn from the loop's own posterior: unconstrained coordinates, and
        amplitudes of the effects that are followed; a starting point and a check, never data
    """

    @property
    def service_hours(self) -> float: ...  # noqa: D102
    @property
    def event(self) -> str | None: ...  # noqa: D102
    @property
    def load_hours(self) -> float | None: ...  # noqa: D102
    @property
    def temperature_C(self) -> float | None: ...  # noqa: D102
    @property
    def posterior(self) -> FloatArray: ...  # noqa: D102

    @property
    def exact(self) -> ExactEvidence | None:
        """The likelihood itself; None where `linearise` is exact everywhere."""
        ...

    def linearise(self, coordinates: FloatArray) -> Linearised:
        """Information form of the loop's likelihood at coordinates (n,)."""
        ...


def in_order(evidence: Sequence[LoopEvidence]) -> tuple[LoopEvidence, ...]:
    """Put tests in order of service hours; those at equal hours stay in the order given.

    Raises
    ------
    BadInputError
        without tests, or for hours or events that cannot be
    """
    if not evidence:
        raise BadInputError(
            found="no tests",
            where="the tests of the drive",
            expected="at least one test",
            advice="Add a row to tests.csv.",
        )
    for number, test in enumerate(evidence, start=1):
        if not np.isfinite(test.service_hours) or test.service_hours < 0:
            raise BadInputError(
                found=f"{test.service_hours} service hours",
                where=f"test {number} of the drive",
                expected="hours in service at the test, zero or more",
                advice="Correct service_hours in tests.csv.",
            )
        if test.event is not None and test.event not in EVENTS:
            raise BadInputError(
                found=f"the event {test.event!r}",
                where=f"test {number} of the drive",
                expected="nothing, or one of " + ", ".join(EVENTS),
                advice="Correct event in tests.csv.",
            )
        if test.posterior.ndim != 2 or test.posterior.shape[1] < len(NAMES):
            raise ValueError(f"posterior of test {number} has shape {test.posterior.shape}")
    return tuple(sorted(evidence, key=lambda test: test.service_hours))
