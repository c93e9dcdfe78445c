"""Tests whose file or readings are those of another test, so that one record counts twice."""

from __future__ import annotations

import filecmp
import hashlib
from collections.abc import MutableMapping, Sequence

from hdprog.data.loop import Loop
from hdprog.data.tests_table import DriveTest

__all__ = ["SAME_READINGS", "copy_doubt", "digest_of_readings", "readings_doubt"]

SAME_READINGS = (
    "Torque and angle are those of test {}, reading by reading, in a file of another form: check "
    "whether one was copied in place of another."
)


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


def digest_of_readings(loop: Loop) -> str:
    """Digest of torque and angle in SI, the same in whatever form a file holds them."""
    digest = hashlib.sha256(loop.torque.tobytes())
    digest.update(loop.angle.tobytes())
    return digest.hexdigest()


def readings_doubt(
    loop: Loop, name: str, before: MutableMapping[str, tuple[str, str]]
) -> str | None:
    """Find a test before this one with the same readings in another file.

    Packed, with other line ends or a decimal comma, or out of a workbook a record is another file.

    Parameters
    ----------
    loop : Loop
        The record of the test.
    name : str
        The test's id.
    before : mapping
        Id and file's digest of the tests before, by digest of their readings; this one is added.

    Returns
    -------
    str or None
        What to check, in words; None where there is no such test, or it has the same file.
    """
    other, file = before.setdefault(digest_of_readings(loop), (name, loop.sha256))
    return None if file == loop.sha256 else SAME_READINGS.format(other)
