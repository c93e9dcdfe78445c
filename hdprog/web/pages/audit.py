"""The audit trail: who changed what."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from starlette.responses import Response

from hdprog.store.audit import trail
from hdprog.web.rendering import render
from hdprog.web.security.identity import Admin
from hdprog.web.service import service_of

router = APIRouter()
_LINES = 100
_LAST = 2**63 - 1  # number that a line can have


@router.get("/audit")
def audit_page(
    request: Request, who: Admin, before: Annotated[int | None, Query(ge=1, le=_LAST)] = None
) -> Response:
    """Show the newest lines, or those before one."""
    with service_of(request).store.reading() as session:
        lines = trail(session, before=before, count=_LINES)
    older = lines[-1].id if len(lines) == _LINES else None
    return render(request, "audit.html", {"lines": lines, "older": older}, who=who)
