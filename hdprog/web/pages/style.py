"""The style of reports, which pages share."""

from __future__ import annotations

from importlib.resources import files

from fastapi import APIRouter
from starlette.responses import Response

router = APIRouter()
_STYLE = (files("hdprog.reporting") / "templates" / "report.css").read_text("utf-8")


@router.get("/static/report.css")
def report_style() -> Response:
    """Give the style of reports."""
    return Response(_STYLE, media_type="text/css", headers={"cache-control": "max-age=3600"})
