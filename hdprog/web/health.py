"""Is the service well? For whoever watches over it; needs no login and tells nothing of drives."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel

from hdprog import __version__
from hdprog.store import jobs, workers
from hdprog.store.database import trouble_with
from hdprog.web.service import service_of

router = APIRouter(tags=["health"])


class Health(BaseModel):
    """The service's state."""

    status: str
    version: str
    database: str
    disk: str
    open_jobs: int | None
    workers: int | None


@router.get("/healthz", responses={503: {"model": Health, "description": "Not well."}})
def health(request: Request, response: Response) -> Health:
    """Say whether the database answers and the disk has room, and how many workers live."""
    service = service_of(request)
    well = trouble_with(service.store.database) is None
    room = service.has_room()
    count, at_work = None, None
    if well:
        with service.store.reading() as session:
            count, at_work = jobs.open_jobs(session), len(workers.alive(session))
    if not (well and room):
        response.status_code = 503
    return Health(
        status="ok" if well and room else "unwell",
        version=__version__,
        database="ok" if well else "no answer",
        disk="ok" if room else "full",
        open_jobs=count,
        workers=at_work,
    )
