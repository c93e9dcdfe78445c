"""Uploads: records are read and shown before they count."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fastapi import APIRouter, Depends, Request
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import FormData, UploadFile
from starlette.responses import RedirectResponse, Response

from hdprog.errors import BadInputError
from hdprog.reporting.words import counted, listed
from hdprog.store.drives import content_of
from hdprog.store.readings import is_current
from hdprog.store.tables import DriveRow, TestRow
from hdprog.store.uploads import (
    TestFacts,
    accept,
    find_test,
    list_tests,
    readable_name,
    remove,
)
from hdprog.web.facts import FIELDS, read_facts
from hdprog.web.lookup import drive_named
from hdprog.web.names import DriveName
from hdprog.web.rendering import render
from hdprog.web.security.identity import Engineer, Identity, form_of_ours
from hdprog.web.service import UnreadableError, service_of

router = APIRouter()
_MOST_SHOWN = 100  # records on a page: a form has a thousand fields at most
_BECAME = {"accepted": "accepted", "removed": "removed or discarded"}


@dataclass(frozen=True)
class Refused:
    """A file that cannot be used."""

    name: str
    problems: tuple[str, ...]


@router.get("/drives/{drive_id}/uploads")
def uploads_page(request: Request, who: Engineer, drive_id: DriveName) -> Response:
    """Show the records that wait for somebody to look at them."""
    return _page(request, who, drive_id, [], [], {}, {})


@router.post("/drives/{drive_id}/uploads", dependencies=[Depends(form_of_ours)])
async def upload(request: Request, who: Engineer, drive_id: DriveName) -> Response:
    """Read records and show what is in them."""
    form = await request.form()
    files = [one for one in form.getlist("files") if isinstance(one, UploadFile) and one.filename]
    if not files:
        return RedirectResponse(f"/drives/{drive_id}?said=empty", 303)
    return await run_in_threadpool(_take_in, request, who, drive_id, files)


@router.post("/drives/{drive_id}/uploads/accept", dependencies=[Depends(form_of_ours)])
async def accept_uploads(request: Request, who: Engineer, drive_id: DriveName) -> Response:
    """Let the records count that the form says all of; the others wait on, with the words why."""
    form = await request.form()
    return await run_in_threadpool(_accept, request, who, drive_id, form)


def _take_in(request: Request, who: Identity, drive_id: str, files: list[UploadFile]) -> Response:
    service = service_of(request)
    service.require_room()
    with service.store.reading() as session:
        name = drive_named(session, drive_id).name
    refused: list[Refused] = []
    known: list[str] = []
    seen: dict[int, str] = {}
    for file in files:
        called = readable_name(file.filename or "")
        try:
            taken = service.take_in(
                who.actor, name, file.file, file.filename or "", TestFacts(), accepted=False
            )
        except UnreadableError as error:
            refused.append(Refused(called, error.problems))
            continue
        first = seen.setdefault(taken.test.id, called)
        if not taken.new and taken.test.state == "accepted":
            known.append(
                f"{called} is test {taken.test.label} of this drive already, byte by byte."
            )
        elif first != called:
            known.append(f"{called} is the same record as {first}, byte by byte: it waits once.")
    if not refused and not known:
        return RedirectResponse(f"/drives/{name}/uploads", 303)
    return _page(request, who, name, refused, known, {}, {}, 422 if refused else 200)


def _accept(request: Request, who: Identity, drive_id: str, form: FormData) -> Response:
    service = service_of(request)
    texts = {name: value for name, value in form.items() if isinstance(value, str)}
    if discarded := texts.get("discard"):
        return _discard(request, who, drive_id, discarded, texts)
    problems: dict[str, str] = {}
    left: list[TestRow] = []
    job_ids: list[str] = []
    with service.store.writing() as session:
        drive = drive_named(session, drive_id, alone=True)
        content = content_of(drive)
        gone = _no_longer_waiting(session, drive, texts)
        for test in list_tests(session, drive, "preview"):
            if f"{test.uid}-service_hours" not in texts:
                continue
            why_not = _accept_one(session, who, test, texts, content)
            if why_not is None:
                job_ids.append(service.ask(session, who.actor, drive, test).id)
            else:
                problems[test.uid] = why_not
                left.append(test)
    if not all(is_current(test.quality, content) for test in left):
        service.read_anew(drive_id)
    if problems or gone:
        if job_ids:
            gone.append(_words_of_accepted(len(job_ids), left))
        status = 422 if problems else 409
        return _page(request, who, drive_id, [], gone, problems, texts, status)
    if len(job_ids) == 1:
        return RedirectResponse(f"/jobs/{job_ids[0]}?said=accepted", 303)
    return RedirectResponse(f"/drives/{drive_id}?said=accepted", 303)


def _accept_one(
    session: Session,
    who: Identity,
    test: TestRow,
    texts: dict[str, str],
    content: Mapping[str, Any],
) -> str | None:
    """Let a record count with what the form says of it; gives the words why not where it cannot."""
    if not is_current(test.quality, content):
        return _words_of_stale(test)
    try:
        facts = read_facts({name: texts.get(f"{test.uid}-{name}", "") for name in FIELDS})
        doubt = test.quality.get("doubt")
        if doubt and f"{test.uid}-sure" not in texts:
            return f"{doubt} Tick the box if it is, or discard the record."
        accept(session, who.actor, test, facts, right_drive=bool(doubt))
    except BadInputError as error:
        return str(error)
    return None


def _no_longer_waiting(session: Session, drive: DriveRow, texts: dict[str, str]) -> list[str]:
    """Say of each record that a form speaks of what became of it, where it waits no more."""
    ending = "-service_hours"
    asked = [name.removesuffix(ending) for name in texts if name.endswith(ending)]
    tests = [find_test(session, uid) for uid in (*asked, texts.get("discard", ""))]
    return [
        f"{test.file_name}: somebody has {_BECAME[test.state]} it meanwhile, as test {test.label}. "
        "Nothing of it was changed now; what was said of it is changed on its own page."
        for test in tests
        if test is not None and test.drive_id == drive.id and test.state in _BECAME
    ]


def _words_of_stale(test: TestRow) -> str:
    return (
        f"{test.file_name}: found what was read with earlier settings of the drive's columns and "
        "rows; expected what those of now make of it. It was read anew: look at what stands below "
        "and accept it. Where that says why it cannot be read, put the drive's settings right, or "
        "discard the record."
    )


def _words_of_accepted(count: int, left: Sequence[TestRow]) -> str:
    words = f"Accepted: {counted(count, 'record')}; the job that is under way brings the results "
    words += "up to date."
    if left:
        words += f" Not accepted: {listed([test.file_name for test in left])}, for what is said "
        words += "below. What stands in the fields is kept."
    return words


def _discard(
    request: Request, who: Identity, drive_id: str, uid: str, texts: dict[str, str]
) -> Response:
    service = service_of(request)
    with service.store.writing() as session:
        drive = drive_named(session, drive_id, alone=True)
        test = find_test(session, uid)
        gone = _no_longer_waiting(session, drive, {"discard": uid})
        if test is not None and test.drive_id == drive.id and test.state == "preview":
            remove(session, who.actor, test)
            service.compare_anew(session, drive)
        left = len(list_tests(session, drive, "preview"))
    if gone:
        return _page(request, who, drive_id, [], gone, {}, texts, 409)
    if left:  # what was said of the others already stays in its fields
        return _page(request, who, drive_id, [], [], {}, texts)
    return RedirectResponse(f"/drives/{drive_id}?said=discarded", 303)


def _page(
    request: Request,
    who: Identity,
    drive_id: str,
    refused: list[Refused],
    known: list[str],
    problems: dict[str, str],
    texts: dict[str, str],
    status: int = 200,
) -> Response:
    with service_of(request).store.reading() as session:
        drive: DriveRow = drive_named(session, drive_id)
        content, waiting = content_of(drive), list_tests(session, drive, "preview")
        previews = waiting[:_MOST_SHOWN]
        context = {
            "drive": drive,
            "previews": previews,
            "more": len(waiting) - len(previews),
            "stale": {test.uid for test in previews if not is_current(test.quality, content)},
            "refused": refused,
            "known": known,
            "problems": problems,
            "texts": texts,
        }
    return render(request, "uploads.html", context, status, who=who)
