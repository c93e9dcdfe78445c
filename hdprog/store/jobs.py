"""Jobs as pages show them: asked for, under way, done; the queue itself is elsewhere."""

from __future__ import annotations

import uuid
from collections.abc import Iterable, Sequence

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from hdprog.store.audit import Actor, note
from hdprog.store.tables import DriveRow, JobRow, TestRow
from hdprog.store.tables.base import now

OPEN = ("queued", "running")
MOST_LOST = 3
"""Workers that a job may cost: one that takes the machine's memory would be begun without end."""


def add_job(session: Session, actor: Actor, drive: DriveRow, test: TestRow | None) -> JobRow:
    """Ask for an analysis of a drive, because of a test or of a change."""
    job = JobRow(
        id=str(uuid.uuid4()),
        drive_id=drive.id,
        test_id=None if test is None else test.id,
        created_by=actor.name,
    )
    session.add(job)
    session.flush()
    return job


def find_job(session: Session, number: str, *, alone: bool = False) -> JobRow | None:
    """Find a job by its number.

    Parameters
    ----------
    session : for looking up, or of a change
    number : the job's
    alone : others who change the job wait until this change is done; for whatever tells by a job's
        state what becomes of it
    """
    asked = select(JobRow).where(JobRow.id == number)
    return session.scalar(asked.with_for_update(of=JobRow) if alone else asked)


def next_job(session: Session, number: str) -> JobRow | None:
    """Find the oldest open job of the drive that a job belongs to; others who change it wait.

    The queue's own clock ticks in seconds: which of a drive's entries comes out first is left open
    where they went in together. What is done first is settled here.
    """
    drive = select(JobRow.drive_id).where(JobRow.id == number).scalar_subquery()
    asked = select(JobRow).where(JobRow.drive_id == drive, JobRow.state.in_(OPEN))
    asked = asked.order_by(JobRow.created_at).limit(1).with_for_update(of=JobRow)
    return session.scalars(asked).first()


def last_job_of(session: Session, drive: DriveRow) -> JobRow | None:
    """Find the newest job of a drive."""
    asked = select(JobRow).where(JobRow.drive_id == drive.id).order_by(JobRow.created_at.desc())
    return session.scalars(asked.limit(1)).first()


def open_jobs_of(session: Session, drive: DriveRow) -> Sequence[JobRow]:
    """Give the open jobs of a drive in their turn: the one under way is the first."""
    asked = select(JobRow).where(JobRow.drive_id == drive.id, JobRow.state.in_(OPEN))
    return session.scalars(asked.order_by(JobRow.state != "running", JobRow.created_at)).all()


def with_open_jobs(session: Session, drives: Iterable[DriveRow]) -> set[int]:
    """Give the numbers of those among some drives that have open jobs."""
    of_them = JobRow.drive_id.in_([drive.id for drive in drives])
    return set(session.scalars(select(JobRow.drive_id).where(of_them, JobRow.state.in_(OPEN))))


def failed_last(session: Session, drives: Iterable[DriveRow]) -> dict[int, JobRow]:
    """Give, by number of drive, the newest job of those among some drives where it failed.

    What a person called off did not fail, and tells nothing of the jobs beside it.
    """
    newest = (
        select(JobRow.drive_id, func.max(JobRow.created_at).label("at"))
        .where(JobRow.drive_id.in_([drive.id for drive in drives]), ~JobRow.cancelled)
        .group_by(JobRow.drive_id)
        .subquery()
    )
    is_newest = (JobRow.drive_id == newest.c.drive_id) & (JobRow.created_at == newest.c.at)
    asked = select(JobRow).join(newest, is_newest)
    asked = asked.where(JobRow.state == "failed", ~JobRow.cancelled)
    return {job.drive_id: job for job in session.scalars(asked)}


def job_of_test(session: Session, test: TestRow) -> JobRow | None:
    """Find the newest job that a test asked for."""
    asked = select(JobRow).where(JobRow.test_id == test.id).order_by(JobRow.created_at.desc())
    return session.scalars(asked.limit(1)).first()


def open_jobs(session: Session) -> int:
    """Count the jobs that wait or are under way."""
    asked = select(func.count()).select_from(JobRow).where(JobRow.state.in_(OPEN))
    return session.scalar(asked) or 0


def start(session: Session, job: JobRow) -> int:
    """Note that a worker took a job up, and give the number of this attempt.

    A job that is under way still has lost the worker that it had.
    """
    job.lost += job.state == "running"
    job.state, job.stage, job.progress, job.error = "running", "starting", 0.0, None
    job.started_at, job.finished_at = now(), None
    job.attempt += 1
    return job.attempt


def advance(session: Session, job: JobRow, attempt: int, stage: str, progress: float) -> bool:
    """Note how far an attempt is; tells whether it may go on."""
    if job.state != "running" or job.attempt != attempt:
        return False
    job.stage, job.progress = stage, min(max(progress, job.progress), 1.0)
    return True


def set_back(session: Session, job: JobRow, attempt: int) -> None:
    """Let a job wait again whose worker was told to stop."""
    if job.state == "running" and job.attempt == attempt:
        job.state, job.stage = "queued", "waiting"
        job.progress, job.started_at = 0.0, None


def finish(session: Session, job: JobRow, attempt: int, analysis: str | None) -> bool:
    """Note that an attempt is done; tells whether it had the right to be."""
    if job.state != "running" or job.attempt != attempt:
        return False
    job.state, job.stage, job.progress = "done", "done", 1.0
    job.finished_at, job.analysis_id = now(), analysis
    return True


def fail(session: Session, job: JobRow, attempt: int, error: str) -> None:
    """Note why an attempt failed, of the jobs that it was to do the work of, too."""
    if job.state != "running" or job.attempt != attempt:
        return
    for one in _covered(session, job):
        one.state, one.stage, one.finished_at = "failed", "failed", now()
        one.error = f"Failed together with job {job.id}, which was to do the work of both: {error}"
    job.state, job.stage, job.error = "failed", "failed", error
    job.finished_at = now()


def cancel(session: Session, actor: Actor, job: JobRow) -> bool:
    """Call a job off, and those that it was to do the work of; tells whether it was still open."""
    if job.state not in OPEN:
        return False
    for one in _covered(session, job):
        words = f" together with job {job.id}, which was to do the work of both"
        _call_off(session, actor, one, words)
    _call_off(session, actor, job)
    return True


def _call_off(session: Session, actor: Actor, job: JobRow, together: str = "") -> None:
    job.state, job.stage, job.cancelled = "failed", "cancelled", True
    job.error = f"Cancelled by {actor.name}{together}. Start it again from the job's page."
    job.finished_at = now()
    note(session, actor, "job cancelled", job.drive.name, job=job.id)


def _covered(session: Session, job: JobRow) -> Sequence[JobRow]:
    """Give the jobs that wait whose work one under way was to do: those of before it began.

    Each of them would make the same analysis again, to be called off or to fail as this one.
    """
    if job.started_at is None:
        return []
    asked = select(JobRow).where(
        JobRow.drive_id == job.drive_id,
        JobRow.state == "queued",
        JobRow.created_at <= job.started_at,
    )
    return session.scalars(asked.with_for_update(of=JobRow)).all()


def waiting_beside(session: Session, job: JobRow) -> Sequence[str]:
    """Give the numbers of a drive's jobs that wait beside the one under way.

    To be asked for before the drive is looked up: what was changed with them is seen then.
    """
    asked = select(JobRow.id).where(JobRow.drive_id == job.drive_id, JobRow.state == "queued")
    return session.scalars(asked).all()


def finish_covered(session: Session, analysis: str, waited: Sequence[str]) -> int:
    """Note that jobs which wait are done as well, where an analysis holds what they ask for.

    Ten uploads or corrections in a row so make one analysis, not ten.

    Parameters
    ----------
    session : of the change
    analysis : number of the analysis
    waited : of the jobs that waited when it looked its drive up

    Returns
    -------
    int
        Number of such jobs.
    """
    asked = select(JobRow).where(JobRow.id.in_(waited), JobRow.state == "queued")
    waiting = session.scalars(asked.with_for_update(of=JobRow)).all()
    for one in waiting:
        one.state, one.stage, one.progress = "done", "done", 1.0
        one.finished_at, one.analysis_id = now(), analysis
    return len(waiting)


def reopen(session: Session, actor: Actor, job: JobRow) -> bool:
    """Let a job that failed or was cancelled wait again; tells whether it had."""
    if job.state != "failed":
        return False
    job.state, job.stage, job.cancelled, job.error = "queued", "waiting", False, None
    job.progress, job.started_at, job.finished_at = 0.0, None, None
    job.lost = 0
    job.created_at = now()  # it goes to the end of the queue, and says how many are before it
    note(session, actor, "job started again", job.drive.name, job=job.id)
    return True


def ahead(session: Session, job: JobRow) -> int:
    """Count the jobs that were asked for before one that waits, and are still open."""
    if job.state != "queued":
        return 0
    asked = select(func.count()).select_from(JobRow)
    asked = asked.where(JobRow.state.in_(OPEN), JobRow.created_at < job.created_at)
    return session.scalar(asked) or 0
