"""Files to take away or to look at: reports, pictures, numbers, records, whole drives."""

from __future__ import annotations

import csv
import io
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import fastapi
from fastapi import APIRouter, Request
from starlette.responses import FileResponse, Response
from starlette.types import Receive, Scope, Send

from hdprog.reporting.picture_data import no_formula
from hdprog.store import analyses
from hdprog.store.folder import export_drive
from hdprog.store.uploads import list_tests
from hdprog.web.lookup import UnknownError, drive_named, test_named
from hdprog.web.names import DriveName, TestName
from hdprog.web.security.headers import FILE_POLICY, REPORT_POLICY
from hdprog.web.security.identity import Viewer
from hdprog.web.service import service_of

router = APIRouter()
_SVG = "image/svg+xml"


@router.get("/drives/{drive_id}/report")
def drive_report(request: Request, who: Viewer, drive_id: DriveName) -> Response:
    """Show the newest report of a drive."""
    return _of_analysis(request, drive_id, "report.html", "text/html", REPORT_POLICY)


@router.get("/drives/{drive_id}/report.html")
def save_report(request: Request, who: Viewer, drive_id: DriveName) -> Response:
    """Hand the newest report of a drive out as a file."""
    name = f"{drive_id}-report.html"
    return _of_analysis(request, drive_id, "report.html", "text/html", REPORT_POLICY, name)


@router.get("/drives/{drive_id}/summary.json")
def save_summary(request: Request, who: Viewer, drive_id: DriveName) -> Response:
    """Hand the newest summary of a drive out as a file."""
    name = f"{drive_id}-summary.json"
    return _of_analysis(request, drive_id, "summary.json", "application/json", FILE_POLICY, name)


@router.get("/drives/{drive_id}/explain.json")
def save_explanation(request: Request, who: Viewer, drive_id: DriveName) -> Response:
    """Hand out what the drive model lacked, as a file."""
    name = f"{drive_id}-explain.json"
    return _of_analysis(request, drive_id, "explain.json", "application/json", FILE_POLICY, name)


@router.get("/drives/{drive_id}/pictures/{number}")
def picture(
    request: Request,
    who: Viewer,
    drive_id: DriveName,
    number: Annotated[int, fastapi.Path(ge=0, le=99)],
) -> Response:
    """Show a picture of the newest analysis."""
    return _of_analysis(request, drive_id, f"pictures/{number}.svg", _SVG, REPORT_POLICY)


@router.get("/drives/{drive_id}/figures.csv")
def save_figures(request: Request, who: Viewer, drive_id: DriveName) -> Response:
    """Hand the figures of merit of all tests out as a table."""
    with service_of(request).store.reading() as session:
        drive = drive_named(session, drive_id, with_result=True)
        fits = {fit.test_id: fit for fit in analyses.fits_of(session, drive)}
        tests = [test for test in list_tests(session, drive, "accepted") if test.id in fits]
    keys = list(dict.fromkeys(key for fit in fits.values() for key in fit.figures))
    levels = ("q05", "q50", "q95")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    facts = ["test_id", "service_hours", "date", "event", "note", "converged"]
    writer.writerow(facts + [f"{key}_{level}" for key in keys for level in levels])
    for test in tests:
        fit, event = fits[test.id], None if test.event is None else test.event.kind
        said = [test.label, test.service_hours, test.tested_on, event, test.note, fit.converged]
        found = [fit.figures.get(key, {}).get(level) for key in keys for level in levels]
        writer.writerow([_cell(value) for value in said] + found)
    return Response(
        text.getvalue(),
        media_type="text/csv; charset=utf-8",
        headers=_as_file(f"{drive_id}-figures.csv"),
    )


@router.get("/drives/{drive_id}/folder.zip")
def save_folder(request: Request, who: Viewer, drive_id: DriveName) -> Response:
    """Hand a drive out as the folder that `hdprog run` takes, packed."""
    service = service_of(request)
    service.require_room()
    place = Path(tempfile.mkdtemp(dir=service.store.files.incoming))
    try:
        with service.store.reading() as session:
            drive = drive_named(session, drive_id)
            export_drive(session, service.store.files, drive, place / "drive" / "folder")
        packed = shutil.make_archive(str(place / "packed"), "zip", place / "drive" / "folder")
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)
        raise
    return _OnceResponse(place, packed, "application/zip", _as_file(f"{drive_id}.zip"))


class _OnceResponse(FileResponse):
    """A file that was made for one answer, whose folder goes however that ends.

    A task in the background is not begun where a part was asked for that the file does not have.
    """

    def __init__(self, place: Path, path: str, kind: str, headers: dict[str, str]) -> None:
        super().__init__(path, media_type=kind, headers=headers)
        self._place = place

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, then remove the folder."""
        try:
            await super().__call__(scope, receive, send)
        finally:
            shutil.rmtree(self._place, ignore_errors=True)


@router.get("/tests/{test_id}/report")
def test_report(request: Request, who: Viewer, test_id: TestName) -> Response:
    """Show the report of a test."""
    service = service_of(request)
    with service.store.reading() as session:
        test = test_named(session, test_id)
        drive, label = test.drive.name, test.label
    return _of_analysis(request, drive, f"tests/{label}.html", "text/html", REPORT_POLICY)


@router.get("/tests/{test_id}/posterior.nc")
def save_posterior(request: Request, who: Viewer, test_id: TestName) -> Response:
    """Hand the draws of a test's fit out as netCDF."""
    service = service_of(request)
    with service.store.reading() as session:
        test = test_named(session, test_id)
        drive, label = test.drive.name, test.label
    name = f"{drive}-{label}.nc"
    kind = "application/x-netcdf"
    return _of_analysis(request, drive, f"posteriors/{label}.nc", kind, FILE_POLICY, name)


@router.get("/tests/{test_id}/record")
def save_record(request: Request, who: Viewer, test_id: TestName) -> Response:
    """Hand a record out as it came."""
    service = service_of(request)
    with service.store.reading() as session:
        test = test_named(session, test_id)
        path, name = service.store.files.record(test.sha256), test.file_name
    return FileResponse(path, media_type="application/octet-stream", headers=_as_file(name))


@router.get("/tests/{test_id}/picture.svg")
def record_picture(request: Request, who: Viewer, test_id: TestName) -> Response:
    """Show the picture of a record."""
    service = service_of(request)
    with service.store.reading() as session:
        test = test_named(session, test_id)
        path = service.store.files.find_picture(test.sha256, test.drive_id)
    if path is None:
        raise UnknownError("picture: found none of this record; expected one. Look at its report.")
    return FileResponse(path, media_type=_SVG, headers={"content-security-policy": REPORT_POLICY})


def _of_analysis(
    request: Request, drive_id: str, file: str, kind: str, policy: str, name: str | None = None
) -> Response:
    """Answer with a file of a drive's newest analysis; `file` is made of the store's names."""
    service = service_of(request)
    with service.store.reading() as session:
        drive = drive_named(session, drive_id, with_result=True)
        path = service.store.files.analysis(str(drive.analysis_id)) / file
    if not path.is_file():
        raise UnknownError(
            f"{Path(file).name}: found no such file in the newest analysis of {drive_id!r}; "
            "expected one of a test that it holds. Wait for the job that is under way."
        )
    headers = {"content-security-policy": policy} | ({} if name is None else _as_file(name))
    return FileResponse(path, media_type=kind, headers=headers)


def _as_file(name: str) -> dict[str, str]:
    """Have a browser save an answer, under a name without signs that could mislead it."""
    plain = "".join(_safe(name))
    return {
        "content-disposition": f'attachment; filename="{plain}"',
        "content-security-policy": FILE_POLICY,
    }


def _safe(name: str) -> Iterator[str]:
    for sign in name:
        yield sign if sign.isascii() and (sign.isalnum() or sign in "-_.+ ") else "_"


def _cell(value: object) -> object:
    return no_formula(value) if isinstance(value, str) else value
