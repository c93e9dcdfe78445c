"""Loads that are given and do not count: of some stretches of service only, or all zero."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

from hdprog.data.tests_table import DriveTest

__all__ = ["drives_of_stretches", "load_doubts"]


def drives_of_stretches(replaced: Sequence[bool]) -> list[int]:
    """Number of the drive that each stretch of service was of, and at the end that of the last one.

    Parameters
    ----------
    replaced : whether the drive was replaced before each test, so that the stretch up to that test
        was still of the one before
    """
    return list(itertools.accumulate(map(int, replaced), initial=0))


def load_doubts(tests: Sequence[DriveTest]) -> Mapping[str, str]:
    """Find what keeps loads that are given from counting.

    Parameters
    ----------
    tests : sequence of DriveTest
        By service hours.

    Returns
    -------
    mapping of str to str
        Name of the test whose stretch lacks its load, or of the first of those whose load is zero →
        what is left out, in words. Empty where all have their load or none has, and of a drive that
        was replaced where none of its own has.
    """
    before = [0.0, *(test.service_hours for test in tests)]
    drives = drives_of_stretches([test.event == "replaced" for test in tests])
    ran = [one for one in zip(before, drives, tests, strict=False) if one[2].service_hours > one[0]]
    for column, what in (("mean_torque_Nm", "Loads"), ("mean_speed_rpm", "Speeds")):
        given = [(drive, getattr(test, column)) for _, drive, test in ran]
        if all(value is None for _, value in given):
            continue
        has = {drive for drive, value in given if value is not None}
        for start, drive, test in ran:
            old = drive != drives[-1]
            if getattr(test, column) is None and (drive in has or not old):
                whose = " of the drive that was replaced" if old else ""
                return {
                    test.test_id: f"{what}{whose} are not counted: {column} is given for other "
                    f"tests, and not for the hours from {start:g} to {test.service_hours:g} before "
                    f"test {test.test_id}. Fill the cell in, with a rough mean if need be."
                }
        if all(value in (None, 0.0) for _, value in given):
            first = next(test for _, _, test in ran if getattr(test, column) == 0.0)
            return {
                first.test_id: f"Loads are not counted: {column} is 0 wherever it is given, from "
                f"test {first.test_id} on, and a drive without load does not wear by it. Give the "
                "means in service, or leave the cells empty."
            }
    return {}
