"""The fleet: all drives, worst first."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from starlette.responses import Response

from hdprog.store import analyses, jobs, workers
from hdprog.store.drives import fleet
from hdprog.store.settings import service_settings
from hdprog.web.rendering import STANDINGS, render
from hdprog.web.security.identity import Viewer
from hdprog.web.service import service_of

router = APIRouter()
_SIZE = 50


@router.get("/")
def fleet_page(
    request: Request,
    who: Viewer,
    page: Annotated[int, Query(ge=1, le=100_000)] = 1,
    q: Annotated[str, Query(max_length=100)] = "",
    status: Annotated[str, Query(max_length=20)] = "",
) -> Response:
    """Show the fleet."""
    with service_of(request).store.reading() as session:
        found = fleet(session, page=page, size=_SIZE, search=q.strip(), status=status or None)
        waiting = jobs.open_jobs(session)
        context = {
            "drives": found.drives,
            "failed": jobs.failed_last(session, found.drives),
            "waiting": jobs.with_open_jobs(session, found.drives),
            "overtaken": analyses.overtaken(session, found.drives),
            "counts": [
                (name, words, found.counts.get(name, 0)) for name, words in STANDINGS.items()
            ],
            "total": sum(found.counts.values()),
            "found": found.found,
            "page": page,
            "pages": max(1, -(-found.found // _SIZE)),
            "q": q,
            "status": status,
            "open_jobs": waiting,
            "nobody": waiting > 0 and not workers.alive(session),
            "place": service_settings(session).title,
        }
    return render(request, "fleet.html", context, who=who)
