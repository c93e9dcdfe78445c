"""What every request needs: the store, the queue and the readers, opened once."""

from __future__ import annotations

import secrets
import tempfile
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fastapi import Request

from hdprog.atomic import atomic_write_text
from hdprog.config import drive_from_mapping
from hdprog.data.copied_records import SAME_READINGS
from hdprog.service.queue import Queue
from hdprog.service.readers import Readers
from hdprog.service.readout import READINGS, ReadOut
from hdprog.service.same_drive import doubt
from hdprog.service.web_settings import WebSettings
from hdprog.store import jobs
from hdprog.store.audit import Actor
from hdprog.store.drives import content_of, find_drive
from hdprog.store.files import free_bytes
from hdprog.store.readings import is_current, reading_of, with_problems, with_reading
from hdprog.store.right_drive import renewed, right_drive_said
from hdprog.store.settings import held_setting
from hdprog.store.store import Store
from hdprog.store.tables import DriveRow, JobRow, TestRow, TokenRow
from hdprog.store.tables.base import now
from hdprog.store.tidy import tidy_up
from hdprog.store.uploads import (
    TestFacts,
    add_test,
    find_record,
    list_tests,
    readable_name,
    refresh_counts,
)
from hdprog.web.lookup import drive_named

_SECRET = "form secret"
_LEAST_FREE = 1 << 30  # bytes of disk below which nothing more is taken in
_READ_IN_ORDER = ("accepted", "preview", "removed")


class UnreadableError(Exception):
    """A record that cannot be used.

    Parameters
    ----------
    problems : in the words of `hdprog check`
    """

    def __init__(self, problems: tuple[str, ...]) -> None:
        super().__init__(*problems)
        self.problems = problems


class NoRoomError(Exception):
    """The disk is full."""


@dataclass(frozen=True)
class Taken:
    """A record that was taken in.

    Attributes
    ----------
    test : that it became, or was already
    job : that was asked for, None while it waits for a person to look
    new : it was not there before
    doubt : why it may be another drive's, unless a person said that it is not
    """

    test: TestRow
    job: JobRow | None
    new: bool
    doubt: str | None


class Service:
    """The open store with what works on it.

    Attributes
    ----------
    settings : how the server was started
    store, queue, readers : what works
    secret : that forms' tokens are made with
    """

    def __init__(self, settings: WebSettings) -> None:
        self.settings = settings
        self.store = Store(settings.data, settings.url)
        self.queue = Queue(self.store.database.url)
        self.readers = Readers(settings.readers)
        self.secret = b""

    def open(self) -> None:
        """Bring the tables up to date and start the readers."""
        self.store.prepare()
        self.queue.prepare()
        tidy_up(self.store)
        # What streams in is put down beside where it is kept, not in a /tmp that may be memory.
        tempfile.tempdir = str(self.store.files.incoming)
        with self.store.writing() as session:
            secret = held_setting(session, _SECRET, {"hex": secrets.token_hex(32)})
            self.secret = bytes.fromhex(secret.value["hex"])
        threading.Thread(target=self.readers.warm_up, daemon=True).start()

    def close(self) -> None:
        """Close everything."""
        self.readers.stop()
        self.queue.close()
        self.store.close()

    def take_in(
        self,
        actor: Actor,
        drive_name: str,
        stream: Any,
        file_name: str,
        facts: TestFacts,
        *,
        accepted: bool,
    ) -> Taken:
        """Read a record, keep it, and ask for an analysis where it counts at once.

        Raises
        ------
        UnreadableError
            for a record that cannot be used
        BadInputError
            for facts that cannot be
        UnknownError
            for a drive that is not there
        """
        facts.check()
        name = readable_name(file_name)
        incoming, digest, size = self.store.files.receive(stream)
        try:
            while True:  # once, unless the settings change while the record is read
                with self.store.reading() as session:
                    content = content_of(drive_named(session, drive_name))
                found = self.readers.read(incoming, name, content)
                if found.problems:
                    raise UnreadableError(found.problems)
                with self.store.writing() as session:
                    drive = drive_named(session, drive_name, alone=True)
                    if reading_of(content_of(drive)) != reading_of(content):
                        continue
                    known = find_record(session, drive, digest)
                    counted = known is not None and known.state == "accepted"
                    compared = _compared(session, drive, content, found.quality, known)
                    test, new = add_test(
                        session,
                        actor,
                        drive,
                        facts,
                        file_name=name,
                        sha256=digest,
                        size=size,
                        quality=with_reading(compared, content),
                        accepted=accepted,
                    )
                    job = jobs.job_of_test(session, test)
                    if accepted:
                        before = job if counted else None
                        job = self._job_of(session, actor, drive, test, before)
                    # Last: what is refused leaves no file, what is written down has its own.
                    self.store.files.keep(incoming, digest)
                    atomic_write_text(self.store.files.picture(digest, drive.id), found.picture)
                    asked = None if right_drive_said(test) else compared["doubt"]
                    return Taken(test, job, new, asked)
        finally:
            incoming.unlink(missing_ok=True)

    def _job_of(
        self, session: Any, actor: Actor, drive: DriveRow, test: TestRow, before: JobRow | None
    ) -> JobRow:
        """Find or ask for the job of a test that counts; `before` is that of one that did before.

        One that failed, unless a person called it off, is started again.
        """
        if before is None:
            return self.ask(session, actor, drive, test)
        if before.state == "failed" and not before.cancelled:
            return self._again(session, actor, drive, before)
        return before

    def read_anew(self, drive_name: str) -> None:
        """Read the records of a drive whose read-out was made with earlier settings.

        One that cannot be read with those of now keeps its read-out, and pages say so.
        """
        with self.store.reading() as session:
            drive = find_drive(session, drive_name)
            if drive is None:
                return
            content = content_of(drive)
            stale = [
                (test.id, test.sha256, test.file_name)
                for state in _READ_IN_ORDER  # the accepted first: the others are compared with them
                for test in list_tests(session, drive, state)
                if not is_current(test.quality, content)
            ]
        for number, digest, name in stale:
            found = self.readers.read(self.store.files.record(digest), name, content)
            if not self._renew(drive_name, number, content, found):
                return

    def _renew(
        self, drive_name: str, number: int, content: Mapping[str, Any], found: ReadOut
    ) -> bool:
        """Keep what was read anew; tells whether the settings are still those it was read with."""
        with self.store.writing() as session:
            drive = find_drive(session, drive_name, alone=True)
            test = session.get(TestRow, number)
            if (
                drive is None
                or test is None
                or reading_of(content_of(drive)) != reading_of(content)
            ):
                return False
            if found.problems:
                test.quality = with_problems(test.quality, found.problems)
                return True
            compared = _compared(session, drive, content, found.quality, test)
            test.quality = renewed(test, with_reading(compared, content))
            atomic_write_text(self.store.files.picture(test.sha256, drive.id), found.picture)
            return True

    def compare_anew(self, session: Any, drive: DriveRow) -> None:
        """Compare a drive's records once more, where one of its tests counts no longer."""
        content = content_of(drive)
        for state in _READ_IN_ORDER:
            for test in list_tests(session, drive, state):
                if is_current(test.quality, content):
                    test.quality = _compared(session, drive, content, test.quality, test)

    def ask(self, session: Any, actor: Actor, drive: DriveRow, test: TestRow | None) -> JobRow:
        """Ask for an analysis, in the transaction of the change that makes it needed."""
        refresh_counts(session, drive)
        job = jobs.add_job(session, actor, drive, test)
        self.queue.enqueue(session, job)
        return job

    def _again(self, session: Any, actor: Actor, drive: DriveRow, job: JobRow) -> JobRow:
        """Start a job again that failed, unless one that is open does its work."""
        for other in jobs.open_jobs_of(session, drive):
            return other
        jobs.reopen(session, actor, job)
        self.queue.enqueue(session, job)
        return job

    def note_token_used(self, number: int) -> None:
        """Remember when a token was last used."""
        with self.store.writing() as session:
            token = session.get(TokenRow, number)
            if token is not None:
                token.used_at = now()

    def has_room(self) -> bool:
        """Tell whether the disk has room for uploads."""
        return free_bytes(self.store.files.root) > _LEAST_FREE

    def require_room(self) -> None:
        """Refuse uploads where the disk is full.

        Raises
        ------
        NoRoomError
            where it is
        """
        if not self.has_room():
            raise NoRoomError(
                f"disk: found less than {_LEAST_FREE >> 30} GiB free where records are kept; "
                "expected more. Whoever runs the server must make room; nothing was taken in."
            )


def _compared(
    session: Any,
    drive: DriveRow,
    content: Mapping[str, Any],
    quality: Mapping[str, Any],
    known: TestRow | None,
) -> dict[str, Any]:
    """Say of a record how it compares with the drive's tests; of one of them, with those before."""
    return {
        **quality,
        "doubt": _doubt(session, drive, content, quality, known),
        "copied": _copied(session, drive, quality, known),
    }


def _doubt(
    session: Any,
    drive: DriveRow,
    content: Mapping[str, Any],
    quality: Mapping[str, Any],
    known: TestRow | None,
) -> str | None:
    """Say in what a record does not look like the drive's accepted tests."""
    tests = list(list_tests(session, drive, "accepted"))
    if known in tests:
        tests = tests[: tests.index(known)]
    earlier = [
        (test.label, test.quality)
        for test in reversed(tests)
        if is_current(test.quality, content)  # another unit makes no other drive
    ]
    return doubt(quality, earlier, drive_from_mapping(content))


def _copied(
    session: Any, drive: DriveRow, quality: Mapping[str, Any], known: TestRow | None
) -> str | None:
    """Say which test of before has a record's readings in another file; None where none has."""
    for test in list_tests(session, drive, "accepted", "preview"):
        earlier = known is None or test.id < known.id
        if earlier and quality.get(READINGS) and test.quality.get(READINGS) == quality[READINGS]:
            return SAME_READINGS.format(test.label)
    return None


def service_of(request: Request) -> Service:
    """Find the service that a request came to."""
    found: Service = request.app.state.service
    return found
