"""Tests of a drive: uploaded, looked at, accepted, removed. The same record is one test."""

from __future__ import annotations

import re
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import date
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from hdprog.data.tests_table import EVENTS
from hdprog.errors import BadInputError
from hdprog.store.audit import Actor, note
from hdprog.store.right_drive import KEY as RIGHT_DRIVE
from hdprog.store.right_drive import mark_right_drive, renewed
from hdprog.store.tables import DriveRow, EventRow, TestRow

_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")  # but for tabs and line breaks
_LABEL = re.compile(r"[\w+\-][\w+\-. ]{0,99}")
COLUMNS = {
    "service_hours": "service_hours",
    "test_id": "label",
    "date": "tested_on",
    "temperature_C": "temperature_C",
    "note": "note",
    "event": "event",
    "mean_torque_Nm": "mean_torque_Nm",
    "mean_speed_rpm": "mean_speed_rpm",
}
"""Columns of tests.csv, and fields of forms, with the facts that they hold."""
_MOST_LABEL_BYTES = 200  # files are named after it, and a name has 255 with what is added to it


@dataclass(frozen=True)
class TestFacts:
    """What a user says of a test, as tests.csv has it; `label` is its test_id.

    `service_hours` may be missing in a preview only.
    """

    __test__ = False  # not a pytest class

    service_hours: float | None = None
    label: str | None = None
    tested_on: date | None = None
    temperature_C: float | None = None
    note: str | None = None
    event: str | None = None
    mean_torque_Nm: float | None = None
    mean_speed_rpm: float | None = None

    def by_column(self) -> dict[str, Any]:
        """Give them as a row of tests.csv has them."""
        return {column: getattr(self, name) for column, name in COLUMNS.items()}

    def check(self) -> None:
        """Refuse what cannot be.

        Raises
        ------
        BadInputError
            naming the field
        """
        if self.event is not None and self.event not in EVENTS:
            raise BadInputError(
                f"the event {self.event!r}",
                "field event",
                "nothing, or one of " + ", ".join(EVENTS),
                "Correct it; anything else belongs into the note.",
            )
        if self.label is not None and (
            not _LABEL.fullmatch(self.label)
            or self.label.endswith((".", " "))
            or len(self.label.encode()) > _MOST_LABEL_BYTES
        ):
            raise BadInputError(
                f"test_id = {self.label!r}",
                "field test_id",
                "a name of letters, digits, _ - + . or spaces, at most 100 of them; of "
                "scripts beyond Latin, Greek and Cyrillic fewer",
                "Rename the test, for example t01, or leave the field out.",
            )
        if self.note is not None and _CONTROL.search(self.note):
            raise BadInputError(
                "a note with signs that cannot be shown",
                "field note",
                "text",
                "Nothing was changed. Type the note anew; what was copied along does not show.",
            )


def add_test(
    session: Session,
    actor: Actor,
    drive: DriveRow,
    facts: TestFacts,
    *,
    file_name: str,
    sha256: str,
    size: int,
    quality: Mapping[str, Any],
    accepted: bool,
) -> tuple[TestRow, bool]:
    """Add a record to a drive, or find the test that it already is, and renew its read-out.

    Parameters
    ----------
    session, actor : of the change
    drive : whose record it is
    facts : what the user says
    file_name : as the user's machine calls it, for people to read
    sha256, size : of the record's bytes, which are kept already
    quality : what was read out of it
    accepted : it counts at once; else it waits for a person to look

    Returns
    -------
    test, new : the test, and whether it was not there before

    Raises
    ------
    BadInputError
        for facts that cannot be, or a test_id that is taken
    """
    facts.check()
    known = find_record(session, drive, sha256)
    if known is not None:
        # The columns may have been named otherwise since: what was read now is what holds.
        known.quality, known.file_name = renewed(known, quality), readable_name(file_name)
        if known.state == "accepted" or not accepted:
            if known.state == "removed":
                known.state = "preview"
                subject = f"{drive.name} / {known.label}"
                note(session, actor, "record uploaded", subject, file=file_name, sha256=sha256)
            return known, False
        refuse_hours_begun_again(session, drive, facts, known)
        _state(known, facts)
        known.state = "accepted"
        note(session, actor, "test accepted", f"{drive.name} / {known.label}", sha256=sha256)
        return known, False
    if facts.label is not None:
        _refuse_taken(session, drive, facts.label)
    refuse_hours_begun_again(session, drive, facts, None)
    test = TestRow(  # by names that no test may have, until the row has its number
        uid=f"/{sha256}",
        drive_id=drive.id,
        label=f"/{sha256}",
        state="accepted" if accepted else "preview",
        file_name=readable_name(file_name),
        sha256=sha256,
        size=size,
        quality=dict(quality),
        uploaded_by=actor.name,
        tested_on=facts.tested_on,
    )
    session.add(test)
    session.flush()
    test.label = _free_label(session, drive, test.id) if facts.label is None else facts.label
    if not _has_uid(session, test, test.label):
        test.uid = f"t{test.id:04d}-{secrets.token_hex(4)}"
    _state(test, facts)
    action = "test accepted" if accepted else "record uploaded"
    note(session, actor, action, f"{drive.name} / {test.label}", file=file_name, sha256=sha256)
    return test, True


def refuse_hours_begun_again(
    session: Session, drive: DriveRow, facts: TestFacts, own: TestRow | None
) -> None:
    """Refuse a new drive's first test at fewer hours than the old one's, as an analysis would.

    Whichever of the two comes second: after it, no analysis of the drive would end.

    Raises
    ------
    BadInputError
        naming the other test
    """
    if facts.service_hours is None:
        return
    for other in list_tests(session, drive, "accepted"):
        if other is own or other.service_hours is None:
            continue
        _refuse_old_beyond_new(facts, other)
        if facts.event != "replaced":
            continue
        earlier = own is None or other.id < own.id
        if facts.tested_on is not None and other.tested_on is not None:
            earlier = other.tested_on < facts.tested_on
        if earlier and other.service_hours > facts.service_hours:
            raise BadInputError(
                f"service_hours = {facts.service_hours:g} of a new drive (event replaced), less "
                f"than the {other.service_hours:g} of test {other.label} before it",
                "field service_hours",
                "hours that go on counting when the drive is replaced",
                "Add the old drive's last hours to those of the new one, or make a drive of its "
                "own for it; where the other test was made later, give the days of both.",
            )


def _refuse_old_beyond_new(facts: TestFacts, other: TestRow) -> None:
    """Refuse a test of the old drive, told by its day, at more hours than the new one's first."""
    is_new = other.event is not None and other.event.kind == "replaced"
    hours, day = facts.service_hours, facts.tested_on
    if not is_new or hours is None or day is None:
        return
    if other.service_hours is None or other.tested_on is None:
        return
    if day < other.tested_on and hours > other.service_hours:
        raise BadInputError(
            f"service_hours = {hours:g} on {day}, more than the "
            f"{other.service_hours:g} of test {other.label} after it, a new drive's first (event "
            "replaced)",
            "field service_hours",
            "hours that go on counting when the drive is replaced",
            f"Correct hours or day of this test, or those of test {other.label} on its page: the "
            "old drive's last hours are added to those of the new one.",
        )


def facts_of(test: TestRow) -> TestFacts:
    """What is said of a test at present."""
    return TestFacts(
        service_hours=test.service_hours,
        label=test.label,
        tested_on=test.tested_on,
        temperature_C=test.temperature_C,
        note=test.note,
        event=None if test.event is None else test.event.kind,
        mean_torque_Nm=test.mean_torque_Nm,
        mean_speed_rpm=test.mean_speed_rpm,
    )


def said_otherwise(test: TestRow, facts: TestFacts) -> tuple[str, ...]:
    """Name the fields in which a test is not what was said of it; what was not said is none."""
    held = facts_of(test).by_column()
    said = {name: value for name, value in facts.by_column().items() if value is not None}
    return tuple(name for name, value in said.items() if value != held[name])


def accept(
    session: Session, actor: Actor, test: TestRow, facts: TestFacts, *, right_drive: bool = False
) -> None:
    """Let a record count, with what the user says of it, or correct what was said of one that does.

    Parameters
    ----------
    session, actor : of the change
    test : the record
    facts : what the user says
    right_drive : the user says that it is this drive's, which its stiffness made one doubt

    Raises
    ------
    BadInputError
        for facts that cannot be
    """
    facts.check()
    refuse_hours_begun_again(session, test.drive, facts, test)
    subject, before = f"{test.drive.name} / {test.label}", _written(facts_of(test))
    _state(test, facts)
    said = _written(facts_of(test))
    if test.state == "accepted":
        note(session, actor, "test changed", subject, before=before, after=said)
    else:
        if right_drive:
            mark_right_drive(test, actor)
            said[RIGHT_DRIVE] = "yes"
        note(session, actor, "test accepted", subject, **said)
    test.state = "accepted"


def _written(facts: TestFacts) -> dict[str, Any]:
    """Write out what is said of a test, for the audit trail; what is not said is left out."""
    said = {name: value for name, value in asdict(facts).items() if value is not None}
    del said["label"]
    return {name: str(value) if isinstance(value, date) else value for name, value in said.items()}


def remove(session: Session, actor: Actor, test: TestRow) -> None:
    """Let a record no longer count; its bytes and what was found stay on record."""
    test.state = "removed"
    note(session, actor, "test removed", f"{test.drive.name} / {test.label}")


def find_test(session: Session, name: str) -> TestRow | None:
    """Find a test by its name in the store."""
    return session.scalar(select(TestRow).where(TestRow.uid == name))


def hold_drive_of(session: Session, name: str) -> None:
    """Have others who change a test's drive wait until this change is done.

    For before the test is read: what was read earlier may be out of date by then.
    """
    drive = select(TestRow.drive_id).where(TestRow.uid == name).scalar_subquery()
    session.execute(select(DriveRow.id).where(DriveRow.id == drive).with_for_update())


def find_record(session: Session, drive: DriveRow, sha256: str) -> TestRow | None:
    """Find the test of a drive that a record is."""
    return session.scalar(
        select(TestRow).where(TestRow.drive_id == drive.id, TestRow.sha256 == sha256)
    )


def list_tests(session: Session, drive: DriveRow, *states: str) -> Sequence[TestRow]:
    """Give the tests of a drive in some states, by service hours."""
    asked = (
        select(TestRow)
        .where(TestRow.drive_id == drive.id, TestRow.state.in_(states))
        .order_by(TestRow.service_hours, TestRow.id)
    )
    return session.scalars(asked).all()


def refresh_counts(session: Session, drive: DriveRow) -> None:
    """Bring what the fleet's page shows of a drive's tests up to date."""
    session.flush()
    accepted = (TestRow.drive_id == drive.id, TestRow.state == "accepted")
    drive.tests = session.scalar(select(func.count()).select_from(TestRow).where(*accepted)) or 0
    newest = session.scalar(
        select(TestRow).where(*accepted).order_by(TestRow.service_hours.desc()).limit(1)
    )
    drive.last_test_hours = None if newest is None else newest.service_hours
    drive.last_test_at = None if newest is None else newest.uploaded_at


def readable_name(name: str) -> str:
    """Give the last part of a file's name as people may see it, without signs that mislead."""
    last = PurePosixPath(PureWindowsPath(name).name).name
    plain = "".join(sign for sign in last if sign.isprintable())
    return plain.strip()[-200:] or "record"


def _state(test: TestRow, facts: TestFacts) -> None:
    """Write down what the user says of a test."""
    test.service_hours = facts.service_hours
    test.tested_on = facts.tested_on
    test.temperature_C = facts.temperature_C
    test.note = facts.note or None
    test.mean_torque_Nm, test.mean_speed_rpm = facts.mean_torque_Nm, facts.mean_speed_rpm
    if facts.event is None:
        test.event = None
    elif test.event is None:
        test.event = EventRow(kind=facts.event)
    else:
        test.event.kind = facts.event


def _refuse_taken(session: Session, drive: DriveRow, label: str) -> None:
    taken = select(TestRow).where(TestRow.drive_id == drive.id, TestRow.label == label)
    if session.scalar(taken) is not None:
        raise BadInputError(
            f"test_id = {label!r} with another record",
            "field test_id",
            "a test_id that this drive has not had yet",
            "Choose another, or leave the field out: the test is then named in order.",
        )


def _free_label(session: Session, drive: DriveRow, number: int) -> str:
    """Make a label that is free in the drive and, with it, in the store."""
    label = f"t{number:04d}"
    taken = select(TestRow).where(TestRow.drive_id == drive.id, TestRow.label == label)
    return label if session.scalar(taken) is None else f"t{number:04d}-{drive.id}"


def _has_uid(session: Session, test: TestRow, name: str) -> bool:
    """Name a test in the store, if no other drive's has that name; tells whether it has it now."""
    if session.scalar(select(TestRow.id).where(TestRow.uid == name)) is not None:
        return False
    try:
        with session.begin_nested():
            test.uid = name
            session.flush()
    except IntegrityError:  # another drive's test took it in this instant
        return False
    return True
