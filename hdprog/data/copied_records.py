"""Tests whose file is that of another test, so that one record counts twice."""

from __future__ import annotations

import filecmp
from collections.abc import Sequence

from hdprog.data.tests_table import DriveTest

__all__ = ["copy_doubt"]


def copy_doubt(test: DriveTest, tests: Sequence[DriveTest]) -> str | None:
    """Find a test before this one with the same file: a trend through both shows no wear.

    Parameters
    ----------
    test : DriveTest
        The test.
    tests : sequence of DriveTest
        All tests of the drive, this one among them.

    Returns
    -------
    str or None
        What to check, in words; None where there is no such test.
    """
    for other in tests:
        if other.test_id == test.test_id:
            return None
        try:
            # Files of one size are read up to where they differ.
            same = filecmp.cmp(other.path, test.path, shallow=False)
        except OSError:  # told of where that file itself is read
            continue
        if same:
            return (
                f"The file is the same as that of test {other.test_id}, byte by byte: check "
                "whether one was copied in place of another."
            )
    return None
