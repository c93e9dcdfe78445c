"""The API of jobs: how far they are, calling them off, starting them again."""

from __future__ import annotations

from fastapi import APIRouter, Request

from hdprog.store import jobs
from hdprog.store.tables import JobRow
from hdprog.web.api.models import JobState, problems
from hdprog.web.lookup import job_numbered
from hdprog.web.names import JobNumber
from hdprog.web.security.identity import ReadingProgram, WritingProgram
from hdprog.web.service import service_of

router = APIRouter(prefix="/api/v1", tags=["jobs"])


@router.get("/jobs/{job_id}", responses=problems(401, 404, 422))
def job_state(request: Request, who: ReadingProgram, job_id: JobNumber) -> JobState:
    """Say how far a job is."""
    with service_of(request).store.reading() as session:
        return _state(job_numbered(session, job_id))


@router.post("/jobs/{job_id}/cancel", responses=problems(401, 403, 404, 422))
def cancel_job(request: Request, who: WritingProgram, job_id: JobNumber) -> JobState:
    """Call a job off; one that is done stays done."""
    with service_of(request).store.writing() as session:
        job = job_numbered(session, job_id, alone=True)
        jobs.cancel(session, who.actor, job)
        return _state(job)


@router.post("/jobs/{job_id}/retry", responses=problems(401, 403, 404, 422))
def retry_job(request: Request, who: WritingProgram, job_id: JobNumber) -> JobState:
    """Let a job that failed or was called off wait again; any other stays as it is."""
    service = service_of(request)
    with service.store.writing() as session:
        job = job_numbered(session, job_id, alone=True)
        if jobs.reopen(session, who.actor, job):
            service.queue.enqueue(session, job)
        return _state(job)


def _state(job: JobRow) -> JobState:
    return JobState.model_validate(
        {
            "id": job.id,
            "state": job.state,
            "progress": job.progress,
            "error": job.error,
            "stage": job.stage,
            "cancelled": job.cancelled,
            "drive_id": job.drive.name,
            "test_id": None if job.test is None else job.test.label,
            "created_at": job.created_at,
            "finished_at": job.finished_at,
        }
    )
