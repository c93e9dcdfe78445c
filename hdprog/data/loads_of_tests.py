"""Loads that are given for some stretches of service and not for all, so that they do not count."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hdprog.data.tests_table import DriveTest

__all__ = ["load_doubts"]


def load_doubts(tests: Sequence[DriveTest]) -> Mapping[str, str]:
    """Find the stretch of service without a load because of which no load counts.

    Parameters
    ----------
    tests : sequence of DriveTest
        By service hours.

    Returns
    -------
    mapping of str to str
        Name of the first test whose stretch lacks it → what is left out, in words. Empty where all
        have their load or none has.
    """
    before = [0.0, *(test.service_hours for test in tests)]
    ran = [(start, one) for start, one in zip(before, tests, strict=False)]
    ran = [(start, test) for start, test in ran if test.service_hours > start]
    for column, what in (("mean_torque_Nm", "Loads are"), ("mean_speed_rpm", "Speeds are")):
        if all(getattr(test, column) is None for test in tests):
            continue
        for start, test in ran:
            if getattr(test, column) is None:
                return {
                    test.test_id: f"{what} not counted: {column} is given for other tests, and not "
                    f"for the hours from {start:g} to {test.service_hours:g} before test "
                    f"{test.test_id}. Fill the cell in, with a rough mean if need be."
                }
    return {}
