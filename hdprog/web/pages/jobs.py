"""A job: how far it is, calling it off, starting it again."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Form, Request
from starlette.responses import RedirectResponse, Response

from hdprog.store import analyses, jobs, workers
from hdprog.web.lookup import job_numbered
from hdprog.web.names import JobNumber
from hdprog.web.rendering import render
from hdprog.web.security.identity import Engineer, Viewer, form_of_ours
from hdprog.web.service import service_of

router = APIRouter()


@router.get("/jobs/{job_id}")
def job_page(request: Request, who: Viewer, job_id: JobNumber) -> Response:
    """Show a job; the page loads itself again while it is open."""
    with service_of(request).store.reading() as session:
        job = job_numbered(session, job_id)
        context = {
            "job": job,
            "open": job.state in jobs.OPEN,
            "ahead": jobs.ahead(session, job),
            "converged": analyses.has_converged(session, job.analysis_id),
            "nobody": job.state in jobs.OPEN and not workers.alive(session),
        }
    return render(request, "job.html", context, who=who)


@router.post("/jobs/{job_id}", dependencies=[Depends(form_of_ours)])
def act(
    request: Request, who: Engineer, job_id: JobNumber, do: Annotated[str, Form()] = ""
) -> Response:
    """Call a job off, or start it again."""
    service = service_of(request)
    said = ""
    with service.store.writing() as session:
        job = job_numbered(session, job_id, alone=True)
        if do == "cancel":
            said = "cancelled" if jobs.cancel(session, who.actor, job) else ""
        elif do == "retry" and jobs.reopen(session, who.actor, job):
            service.queue.enqueue(session, job)
            said = "again"
    return RedirectResponse(f"/jobs/{job_id}" + (f"?said={said}" if said else ""), 303)
