"""A drive folder: drive.toml, tests.csv and the loop files that it lists."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hdprog.config import Drive, read_drive
from hdprog.data.copied_records import copy_doubt, readings_doubt
from hdprog.data.loads_of_tests import load_doubts
from hdprog.data.loop import Loop
from hdprog.data.order_of_tests import order_doubts
from hdprog.data.readers import read_loop
from hdprog.data.tests_table import EVENTS, DriveTest, read_tests
from hdprog.errors import BadInputError

__all__ = [
    "EVENTS",
    "DriveFolder",
    "DriveTest",
    "files_of",
    "read_drive_folder",
    "read_test_loop",
    "read_test_loops",
    "require_drive_folder",
]


@dataclass(frozen=True)
class DriveFolder:
    """A drive, and its tests by service hours."""

    drive: Drive
    tests: tuple[DriveTest, ...]
    path: Path


def files_of(folder: DriveFolder, loops: Sequence[Loop]) -> dict[str, str]:
    """SHA-256 of each test's file (loops in their order), by its path from the drive's folder."""
    paths = [os.path.relpath(test.path, folder.path) for test in folder.tests]
    return {Path(at).as_posix(): loop.sha256 for at, loop in zip(paths, loops, strict=True)}


def require_drive_folder(path: Path) -> None:
    """Refuse a path that is no drive folder.

    Raises
    ------
    BadInputError
        No such folder, or no drive.toml in it.
    """
    advice = "Give the path of a folder with drive.toml and tests.csv in it."
    if not path.is_dir():
        raise BadInputError(
            "a file" if path.exists() else "no such folder", str(path), "a drive folder", advice
        )
    if not (path / "drive.toml").is_file():
        raise BadInputError(
            "a folder without drive.toml",
            str(path),
            "a drive folder",
            f"{advice} A folder of several drive folders is for `hdprog fleet`.",
        )


def read_drive_folder(path: str | Path) -> DriveFolder:
    """Read a drive and the list of its tests; the loops are read by `read_test_loop`.

    Parameters
    ----------
    path : str or Path
        The folder.

    Raises
    ------
    BadInputError
        A file that is missing, a drive.toml or tests.csv that is wrong, a loop file that is
        missing or lies outside the folder.
    """
    path = Path(path)
    require_drive_folder(path)
    drive = read_drive(path)
    tests, problems = read_tests(path)
    if problems:
        raise problems[0]
    return DriveFolder(drive, tests, path)


def read_test_loop(folder: DriveFolder, test: DriveTest) -> Loop:
    """Read the loop of one test, with the columns and the selection that the drive declares.

    The record carries on what is doubtful of its place among the tests.

    Raises
    ------
    BadInputError
        The file is not a usable record.
    """
    try:
        loop = read_loop(test.path, drive=folder.drive)
    except BadInputError as error:
        raise _of_a_folder(error) from error
    found = (order_doubts(folder.tests), load_doubts(folder.tests))
    doubts = tuple(said[test.test_id] for said in found if test.test_id in said)
    copied = copy_doubt(test, folder.tests)
    if copied is not None:
        doubts = (*doubts, copied)
    return loop.with_warnings(doubts) if doubts else loop


def read_test_loops(folder: DriveFolder) -> list[Loop]:
    """Read the loops of all tests; one with the readings of a test before it says so.

    Raises
    ------
    BadInputError
        A file is not a usable record.
    """
    loops, before = [], dict[str, tuple[str, str]]()
    for test in folder.tests:
        loop = read_test_loop(folder, test)
        doubt = readings_doubt(loop, test.test_id, before)
        loops.append(loop if doubt is None else loop.with_warnings((doubt,)))
    return loops


def _of_a_folder(error: BadInputError) -> BadInputError:
    """Say where a drive declares its columns: commands on whole drives have no --columns."""
    if "--columns" not in error.advice or "[columns]" in error.advice:
        return error
    advice = f"{error.advice} For all tests of a drive: the same under [columns] in its drive.toml."
    return BadInputError(error.found, error.where, error.expected, advice)
