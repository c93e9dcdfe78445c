"""The API of drives."""

from __future__ import annotations

from typing import Annotated, Any
from urllib.parse import quote

from fastapi import APIRouter, BackgroundTasks, Query, Request, Response
from fastapi.responses import FileResponse

from hdprog import __version__
from hdprog.reporting.fleet_words import PROVISIONAL
from hdprog.store import analyses, jobs
from hdprog.store.drives import add_drive, change_drive, fleet
from hdprog.store.tables import DriveRow
from hdprog.web.api.models import DriveFile, DriveLine, DriveList, DriveMade, problems
from hdprog.web.lookup import drive_named
from hdprog.web.names import DriveName
from hdprog.web.security.headers import REPORT_POLICY
from hdprog.web.security.identity import ReadingProgram, WritingProgram
from hdprog.web.service import service_of

router = APIRouter(prefix="/api/v1", tags=["drives"])


@router.get("/drives", responses=problems(401, 422))
def list_drives(
    request: Request,
    who: ReadingProgram,
    page: Annotated[int, Query(ge=1, le=100_000)] = 1,
    size: Annotated[int, Query(ge=1, le=500)] = 50,
) -> DriveList:
    """List drives, worst first."""
    with service_of(request).store.reading() as session:
        found = fleet(session, page=page, size=size)
        outdated = analyses.overtaken(session, found.drives)
        lines = [_line(drive, drive.id in outdated) for drive in found.drives]
        return DriveList(drives=lines, found=found.found, page=page)


@router.post("/drives", status_code=201, responses=problems(400, 401, 403, 409, 413, 422))
def make_drive(
    request: Request, response: Response, who: WritingProgram, content: DriveFile
) -> DriveMade:
    """Make a drive of the content of a drive.toml."""
    with service_of(request).store.writing() as session:
        drive = add_drive(session, who.actor, content.declared)
        made = _made(drive)
    response.headers["location"] = f"/api/v1{made.url}"
    return made


@router.put("/drives/{drive_id}", responses=problems(400, 401, 403, 404, 413, 422))
def declare_drive(
    request: Request,
    who: WritingProgram,
    drive_id: DriveName,
    content: DriveFile,
    afterwards: BackgroundTasks,
) -> DriveMade:
    """Declare a drive anew; where it has tests they are analysed again."""
    service = service_of(request)
    afterwards.add_task(service.read_anew, drive_id)
    with service.store.writing() as session:
        drive = drive_named(session, drive_id, alone=True)
        change_drive(session, who.actor, drive, content.declared)
        if drive.tests:
            service.ask(session, who.actor, drive, None)
        return _made(drive)


@router.get("/drives/{drive_id}", responses=problems(401, 404, 422))
def drive_summary(request: Request, who: ReadingProgram, drive_id: DriveName) -> dict[str, Any]:
    """Give the newest summary of a drive, schema hdprog.summary/1.

    `tests` is empty and `verdict` null until a first analysis is done; `waiting` counts the jobs
    that are not done yet, and `outdated` says that the summary lacks what was uploaded or changed
    since, whatever became of its job.
    """
    service = service_of(request)
    with service.store.reading() as session:
        drive = drive_named(session, drive_id)
        waiting = len(jobs.open_jobs_of(session, drive))
        if drive.analysis_id is None:
            return {**_nothing_yet(drive), "waiting": waiting, "outdated": False}
        return {
            **analyses.summary_of(service.store.files, drive.analysis_id),
            "waiting": waiting,
            "outdated": drive.id in analyses.overtaken(session, [drive]),
        }


@router.get(
    "/drives/{drive_id}/report",
    response_class=FileResponse,
    responses={200: {"content": {"text/html": {}}}, **problems(401, 404, 422)},
)
def drive_report(request: Request, who: ReadingProgram, drive_id: DriveName) -> FileResponse:
    """Give the newest report of a drive, one HTML file."""
    service = service_of(request)
    with service.store.reading() as session:
        drive = drive_named(session, drive_id, with_result=True)
        path = service.store.files.analysis(str(drive.analysis_id)) / "report.html"
    return FileResponse(
        path, media_type="text/html", headers={"content-security-policy": REPORT_POLICY}
    )


def _made(drive: DriveRow) -> DriveMade:
    # An id may be of any letters, an address and a header may not.
    return DriveMade(id=drive.name, url=f"/drives/{quote(drive.name, safe='')}")


def _line(drive: DriveRow, outdated: bool) -> DriveLine:
    remaining = {name: drive.remaining.get(name) for name in ("q05", "q50", "q95")}
    return DriveLine(
        id=drive.name,
        status=drive.status,
        provisional=drive.provisional,
        sentence=f"{drive.sentence} {PROVISIONAL}" if drive.provisional else drive.sentence,
        tests=drive.tests,
        last_test_hours=drive.last_test_hours,
        remaining_hours=remaining,
        inspect_before_hours=drive.remaining.get("inspect_before"),
        outdated=outdated,
    )


def _nothing_yet(drive: DriveRow) -> dict[str, Any]:
    return {
        "schema": "hdprog.summary/1",
        "hdprog_version": __version__,
        "seed": None,
        "drive": {"id": drive.name, "model": drive.settings.get("drive", {}).get("model")},
        "converged": None,
        "verdict": None,
        "tests": [],
        "trend": None,
        "forecast": [],
        "warnings": ["No test of this drive has been analysed yet."],
    }
