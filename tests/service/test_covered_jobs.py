"""One analysis does for all that was asked for before it looked its drive up."""

from __future__ import annotations

import threading

from sqlalchemy.orm import Session

from hdprog.service.analyse import Analysis
from hdprog.service.worker import WorkerSettings, _run_next
from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.store import Store
from hdprog.store.tables import JobRow
from hdprog.store.uploads import TestFacts
from tests.store.samples import add_bytes, add_sample


def test_corrections_in_a_row_make_one_analysis(sqlite_store: Store) -> None:
    """Each of them had made one of its own, all of the same."""
    store = sqlite_store
    with store.writing() as session:
        drive = add_sample(session)
        add_bytes(session, store.files, drive, b"a", TestFacts(1.0))
        under_way, *corrections = [
            jobs.add_job(session, COMMAND_LINE, drive, None) for _ in range(4)
        ]
        attempt = jobs.start(session, under_way)
        assert jobs.cancel(session, COMMAND_LINE, corrections.pop())
    asked = Analysis(store, under_way.id, attempt)._asked()
    assert asked is not None
    waited = asked[-1]
    with store.writing() as session:
        later = jobs.add_job(session, COMMAND_LINE, drive, None)
        assert jobs.finish_covered(session, "the analysis", waited) == 2
    with store.reading() as session:
        states = {job.id: job.state for job in session.query(JobRow)}
    assert [states[one.id] for one in corrections] == ["done", "done"]
    assert states[later.id] == "queued"


def three_in_a_row(session: Session) -> tuple[JobRow, JobRow, JobRow, int]:
    """Make a job that is under way, one that waited when it began, and one of after."""
    drive = add_sample(session)
    under_way, waited = (jobs.add_job(session, COMMAND_LINE, drive, None) for _ in range(2))
    attempt = jobs.start(session, under_way)
    return under_way, waited, jobs.add_job(session, COMMAND_LINE, drive, None), attempt


def test_what_waited_for_a_cancelled_job_is_cancelled_with_it(store: Store) -> None:
    """Each upload in the queue began the analysis that was called off once more."""
    with store.writing() as session:
        under_way, waited, later, _ = three_in_a_row(session)
        assert jobs.cancel(session, COMMAND_LINE, under_way)
    with store.reading() as session:
        kept = session.get_one(JobRow, waited.id)
        assert (kept.state, kept.stage, kept.cancelled) == ("failed", "cancelled", True)
        assert kept.error is not None
        assert under_way.id in kept.error
        assert session.get_one(JobRow, later.id).state == "queued"


def test_what_waited_for_a_failed_job_fails_with_it(store: Store) -> None:
    with store.writing() as session:
        under_way, waited, later, attempt = three_in_a_row(session)
        jobs.fail(session, under_way, attempt + 1, "too late to have the right")
        assert waited.state == "queued"
        jobs.fail(session, under_way, attempt, "The process was killed.")
    with store.reading() as session:
        kept = session.get_one(JobRow, waited.id)
        assert (kept.state, kept.cancelled) == ("failed", False)
        assert kept.error == (
            f"Failed together with job {under_way.id}, which was to do the work of both: The "
            "process was killed."
        )
        assert session.get_one(JobRow, later.id).state == "queued"


def test_a_job_that_waits_is_cancelled_alone(store: Store) -> None:
    with store.writing() as session:
        under_way, waited, later, _ = three_in_a_row(session)
        assert jobs.cancel(session, COMMAND_LINE, waited)
        assert (under_way.state, later.state) == ("running", "queued")


def test_a_job_that_is_given_up_keeps_what_was_asked_for_since_its_last_try(
    store: Store,
) -> None:
    with store.writing() as session:
        under_way, waited, later, _ = three_in_a_row(session)
        under_way.lost = jobs.MOST_LOST - 1
    settings = WorkerSettings(store.files.root, store.database.url, 1)
    assert _run_next(store, settings, under_way.id, threading.Event()) == "failed"
    with store.reading() as session:
        states = [session.get_one(JobRow, one.id).state for one in (under_way, waited, later)]
    assert states == ["failed", "failed", "queued"]
