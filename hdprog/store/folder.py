"""A drive as a folder: drive.toml, tests.csv and the loop files; out of the store and into it."""

from __future__ import annotations

import csv
import hashlib
import io
import math
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import tomli_w
from sqlalchemy.orm import Session

from hdprog.atomic import atomic_directory, atomic_write_text
from hdprog.data.drive_folder import read_drive_folder
from hdprog.data.tests_table import DriveTest
from hdprog.errors import BadInputError
from hdprog.store.audit import Actor, note
from hdprog.store.drives import add_drive, content_of, declare_new
from hdprog.store.files import Files
from hdprog.store.readings import with_reading
from hdprog.store.tables import DriveRow, TestRow
from hdprog.store.uploads import COLUMNS, TestFacts, add_test, facts_of, list_tests, refresh_counts

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
_ENDING = re.compile(r"\.(csv|tsv|txt|dat|xlsx)(\.gz)?$|\.gz$", re.IGNORECASE)


def write_drive_folder(
    files: Files, content: dict[str, Any], tests: Sequence[TestRow], folder: Path
) -> None:
    """Write a drive's folder, whole or not at all.

    Parameters
    ----------
    files : of the store
    content : of drive.toml
    tests : to be listed, with their records
    folder : to be made
    """
    with atomic_directory(folder) as aside:
        (aside / "loops").mkdir()
        atomic_write_text(aside / "drive.toml", tomli_w.dumps(content))
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        facts = [column for column in COLUMNS if column != "test_id"]
        writer.writerow(["test_id", "file", *facts])
        for test in tests:
            file = f"loops/{test.label}{_ending(test.file_name)}"
            if (aside / file).exists():  # t01 of a.csv.gz, and t01.csv of b.gz
                file = f"loops/{test.label}-{test.sha256[:16]}{_ending(test.file_name)}"
            (aside / file).write_bytes(files.record(test.sha256).read_bytes())
            said = facts_of(test).by_column()
            writer.writerow([test.label, file, *(_cell(said[column]) for column in facts)])
        atomic_write_text(aside / "tests.csv", text.getvalue())


def export_drive(session: Session, files: Files, drive: DriveRow, folder: Path) -> int:
    """Write a drive and its accepted tests as a folder; gives the number of tests."""
    tests = list_tests(session, drive, "accepted")
    write_drive_folder(files, content_of(drive), tests, folder)
    return len(tests)


def require_importable(session: Session, folder: Path) -> str:
    """Refuse a drive's folder that cannot be taken in, whatever its records hold; gives its id.

    Raises
    ------
    BadInputError
        for anything in the folder that cannot be used, or a drive that is there already
    """
    tests, seen = read_drive_folder(folder).tests, dict[str, str]()
    with _named(folder):
        drive = declare_new(session, _content(folder))
        for test in tests:
            _said(test).check()
    for test in tests:
        with test.path.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
        if seen.setdefault(digest, test.test_id) != test.test_id:
            raise _same_record(folder, test.test_id, seen[digest])
    return drive.id


def import_drive(
    session: Session,
    files: Files,
    actor: Actor,
    folder: Path,
    looked: Mapping[Path, tuple[dict[str, Any], str]],
) -> tuple[DriveRow, list[TestRow]]:
    """Take a drive's folder into the store, all of it or nothing.

    Parameters
    ----------
    session, files : of the store
    actor : who
    folder : with drive.toml, tests.csv and the loop files
    looked : what is kept of each record's read-out, and its picture as an SVG, by its path

    Raises
    ------
    BadInputError
        for anything in the folder that cannot be used, or a drive that is there already
    """
    read = read_drive_folder(folder)
    content = _content(folder)
    drive = add_drive(session, actor, content)
    rows = []
    for test in read.tests:
        quality, picture = looked[test.path]
        with test.path.open("rb") as stream:
            incoming, digest, size = files.receive(stream)
        files.keep(incoming, digest)
        atomic_write_text(files.picture(digest, drive.id), picture)
        row, new = add_test(
            session,
            actor,
            drive,
            _said(test),
            file_name=test.path.name,
            sha256=digest,
            size=size,
            quality=with_reading(quality, content),
            accepted=True,
        )
        if not new:
            raise _same_record(folder, test.test_id, row.label)
        rows.append(row)
    refresh_counts(session, drive)
    note(session, actor, "drive imported", drive.name, tests=len(rows))
    return drive, rows


@contextmanager
def _named(folder: Path) -> Iterator[None]:
    """Say of what cannot be used in which of several folders it stands."""
    try:
        yield
    except BadInputError as error:
        where = f"{folder}, {error.where}"
        raise BadInputError(error.found, where, error.expected, error.advice) from error


def _content(folder: Path) -> dict[str, Any]:
    return tomllib.loads((folder / "drive.toml").read_text("utf-8-sig"))


def _same_record(folder: Path, test: str, other: str) -> BadInputError:
    return BadInputError(
        f"the same record as that of test {other}",
        f"{folder}, test {test}",
        "records that differ",
        "Remove the test whose record was copied in place of another.",
    )


def _said(test: DriveTest) -> TestFacts:
    return TestFacts(
        service_hours=test.service_hours,
        label=test.test_id,
        tested_on=test.date,
        temperature_C=test.temperature_C,
        note=test.note,
        event=test.event,
        mean_torque_Nm=test.mean_torque_Nm,
        mean_speed_rpm=test.mean_speed_rpm,
    )


def _cell(value: object) -> str:
    """Write a cell; a note loses the line breaks that tests.csv's reader would trip over."""
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.0f}" if value == math.floor(value) else repr(value)
    return " ".join(_CONTROL.sub(" ", str(value)).split())


def _ending(name: str) -> str:
    found = _ENDING.search(name)
    return found[0].lower() if found else ".csv"
