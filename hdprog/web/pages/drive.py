"""A drive: its verdict, trend, forecast and tests, and the form for the next record."""

from __future__ import annotations

import json
from typing import Any

from fastapi import APIRouter, Request
from starlette.responses import Response

from hdprog.config import ForecastSettings
from hdprog.reporting.fleet_words import without_pace
from hdprog.store import analyses, jobs
from hdprog.store.drives import content_of
from hdprog.store.right_drive import open_doubt
from hdprog.store.uploads import list_tests
from hdprog.web.lookup import drive_named
from hdprog.web.names import DriveName
from hdprog.web.rendering import render_of_drive
from hdprog.web.security.identity import Viewer
from hdprog.web.service import Service, service_of

router = APIRouter()


@router.get("/drives/{drive_id}")
def drive_page(request: Request, who: Viewer, drive_id: DriveName) -> Response:
    """Show a drive."""
    service = service_of(request)
    with service.store.reading() as session:
        drive = drive_named(session, drive_id)
        history = analyses.analyses_of(session, drive, 20)
        fits = analyses.fits_of(session, drive)
        content = content_of(drive)
        forecast = content.get("forecast", {})
        tests = list_tests(session, drive, "accepted")
        context = {
            "drive": drive,
            "lead": without_pace(drive.sentence or ""),
            "content": content,
            "accepted_risk": forecast.get("acceptable_risk", ForecastSettings.acceptable_risk),
            "tests": tests,
            "doubted": [test for test in tests if open_doubt(test, content)],
            "previews": list_tests(session, drive, "preview"),
            "removed": list_tests(session, drive, "removed"),
            "fits": {fit.test_id: fit for fit in fits},
            "forecasts": analyses.forecasts_of(session, drive),
            "history": history,
            "then": analyses.first_limits(session, history),
            "open_jobs": jobs.open_jobs_of(session, drive),
            "failed": jobs.failed_last(session, [drive]).get(drive.id),
            "overtaken": drive.id in analyses.overtaken(session, [drive]),
            "last_job": jobs.last_job_of(session, drive),
            "pictures": pictures(service, drive.analysis_id),
            "warnings": warnings(service, drive.analysis_id),
            "verdict": next((one for one in history if one.id == drive.analysis_id), None),
        }
    return render_of_drive(request, "drive.html", content, context, who=who)


def warnings(service: Service, analysis: str | None) -> list[str]:
    """Give what an analysis warns of in the drive and its trend, beside what its verdict says.

    Tests have pages of their own.
    """
    if analysis is None or not (service.store.files.analysis(analysis) / "summary.json").is_file():
        return []
    summary = analyses.summary_of(service.store.files, analysis)
    of_trend = (summary.get("trend") or {}).get("warnings", [])
    said = summary.get("verdict", {}).get("sentences", [])
    return [
        text
        for text in dict.fromkeys([*summary.get("warnings", []), *of_trend])
        if text not in said
    ]


def pictures(service: Service, analysis: str | None) -> list[dict[str, Any]]:
    """Give the words of an analysis's pictures, in their order."""
    if analysis is None:
        return []
    path = service.store.files.analysis(analysis) / "pictures" / "pictures.json"
    if not path.is_file():
        return []
    found: list[dict[str, Any]] = json.loads(path.read_text("utf-8"))
    return found
