"""The work of a job: a drive out of the store, through the workflow, its results back in.

Run by a worker as ``python -m hdprog.service.analyse``; see `hdprog.service.job_process`.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
import traceback
import uuid
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from sqlalchemy.exc import OperationalError

from hdprog.errors import HdprogError, no_room
from hdprog.reporting.fleet_words import fleet_entry
from hdprog.service.drive_run import Order, run_here
from hdprog.service.job_process import take_order
from hdprog.store import analyses, jobs
from hdprog.store.analyses import Standing
from hdprog.store.database import patiently
from hdprog.store.drives import content_of
from hdprog.store.folder import write_drive_folder
from hdprog.store.settings import service_settings
from hdprog.store.store import Store
from hdprog.store.tables import AnalysisRow, DriveRow, TestRow
from hdprog.store.uploads import list_tests

_SAY_EVERY = 0.5  # seconds between two writes of how far it is


class _CalledOffError(Exception):
    """The job was cancelled, or another attempt took its place."""


class Analysis:
    """One attempt at a job.

    Parameters
    ----------
    store : where the drive is and the results go
    job_id, attempt : which job, and the how manieth try
    """

    def __init__(self, store: Store, job_id: str, attempt: int) -> None:
        self.store, self.job_id, self.attempt = store, job_id, attempt
        self._said = ("", 0.0)

    def run(self, processes: int, dask: str | None) -> None:
        """Do the work.

        Raises
        ------
        HdprogError
            for a drive that cannot be analysed, in words for its owner
        """
        asked = patiently(self._asked)
        if asked is None:
            return
        name, content, tests, quick, waited = asked
        if not tests:
            patiently(self._nothing_left)
            return
        number = str(uuid.uuid4())
        out = self.store.files.analysis(number)
        try:
            with tempfile.TemporaryDirectory(dir=self.store.files.incoming) as place:
                folder = Path(place) / "drive"
                write_drive_folder(self.store.files, content, tests, folder)
                order = Order(folder, out, quick, processes, f"hdprog serve, drive {name}")
                if dask is None:
                    run_here(order, self.say)
                else:
                    from hdprog.service.dask_run import run_on_dask

                    run_on_dask(dask, order, self.say)
            replaced = patiently(partial(self._record, number, tests, waited))
        except BaseException:
            shutil.rmtree(out, ignore_errors=True)
            raise
        if replaced is not None:
            self.store.files.drop_posteriors(replaced)

    def say(self, stage: str, done: float) -> None:
        """Write down how far the work is, now and then; stops it where it was called off."""
        before, at = self._said
        moment = time.monotonic()
        if stage == before and moment - at < _SAY_EVERY:
            return
        self._said = (stage, moment)
        with suppress(OperationalError), self.store.writing() as session:
            job = jobs.find_job(session, self.job_id, alone=True)
            if job is None or not jobs.advance(session, job, self.attempt, stage, done):
                raise _CalledOffError

    def fail(self, words: str) -> None:
        """Write down why it failed."""

        def write() -> None:
            with self.store.writing() as session:
                job = jobs.find_job(session, self.job_id, alone=True)
                if job is not None:
                    jobs.fail(session, job, self.attempt, words)

        patiently(write)

    def _asked(self) -> tuple[str, dict[str, Any], Sequence[TestRow], bool, Sequence[str]] | None:
        """Look up the drive's name and content, its tests, whether to be quick, what else waits."""
        with self.store.reading() as session:
            job = jobs.find_job(session, self.job_id)
            if job is None:
                return None
            waited = jobs.waiting_beside(session, job)  # first: what came with them is seen below
            drive = session.get_one(DriveRow, job.drive_id, populate_existing=True)
            tests = list_tests(session, drive, "accepted")
            quick = service_settings(session).quick
            return drive.name, content_of(drive), tests, quick, waited

    def _record(self, number: str, tests: Sequence[TestRow], waited: Sequence[str]) -> str | None:
        summary = analyses.summary_of(self.store.files, number)
        with self.store.writing() as session:
            if session.get(AnalysisRow, number) is not None:
                return None  # kept by the try before, whose answer was lost on its way
            job = jobs.find_job(session, self.job_id, alone=True)
            if job is None or not jobs.finish(session, job, self.attempt, number):
                raise _CalledOffError
            replaced = analyses.record(session, job, number, tests, summary, standing(summary))
            session.flush()
            jobs.finish_covered(session, number, waited)
        return replaced

    def _nothing_left(self) -> None:
        """Take back what was said of a drive whose tests were all removed."""
        with self.store.writing() as session:
            job = jobs.find_job(session, self.job_id, alone=True)
            if job is None or not jobs.finish(session, job, self.attempt, None):
                return
            analyses.forget_standing(session.get_one(DriveRow, job.drive_id))


def standing(summary: dict[str, Any]) -> Standing:
    """Say what the fleet's page shows of a drive."""
    entry = fleet_entry(summary)
    remaining = dict(entry.remaining_hours)
    if remaining:
        remaining["inspect_before"] = entry.inspect_before_hours
    return Standing(
        status=entry.status,
        provisional=entry.provisional,
        label=entry.label,
        sentence=entry.sentence,
        rank=entry.rank,
        rank_hours=entry.rank_hours,
        remaining=remaining,
        sparkline={} if entry.course is None else asdict(entry.course),
        warnings=entry.warnings,
    )


def main() -> int:
    """Do what the worker's order says; gives the exit code."""
    order: dict[str, Any] = take_order()
    store = Store(Path(order["data"]), order["url"])
    attempt = Analysis(store, order["job"], order["attempt"])
    try:
        attempt.run(order["processes"], order["dask"])
    except _CalledOffError:
        return 0
    except HdprogError as error:
        attempt.fail(str(error))
    except Exception as error:
        traceback.print_exc()
        attempt.fail(_words(error))
    return 0


def _words(error: Exception) -> str:
    """Say what went wrong where no words were made for it."""
    if (full := no_room(error)) is not None:
        return (
            f"{full}: found no room for the results; expected room in the data "
            "folder and where temporary files go. Free space on the worker's disk, then start the "
            "job again. The upload itself is safe."
        )
    return (
        f"hdprog stopped through a mistake of its own: {type(error).__name__}: {error}. "
        "The worker's log says more; please report it. The upload itself is safe."
    )


if __name__ == "__main__":
    sys.exit(main())
