"""What is declared of a drive, to be changed in a form or as its drive.toml."""

from __future__ import annotations

import tomllib
from typing import Annotated, Any

import tomli_w
from fastapi import APIRouter, Depends, Form, Request
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.responses import RedirectResponse, Response

from hdprog.errors import BadInputError
from hdprog.store.drives import change_drive, content_of
from hdprog.web.drive_form import content_of_form, context_of, fields_of
from hdprog.web.lookup import drive_named
from hdprog.web.names import DriveName
from hdprog.web.rendering import render
from hdprog.web.security.identity import Engineer, Identity, form_of_ours
from hdprog.web.seen import UnseenError, refuse_unseen, seen
from hdprog.web.service import service_of

router = APIRouter()


@router.get("/drives/{drive_id}/settings")
def settings_page(request: Request, who: Engineer, drive_id: DriveName) -> Response:
    """Show what is declared."""
    return _page_of_now(request, who, drive_id)


@router.post("/drives/{drive_id}/settings", dependencies=[Depends(form_of_ours)])
async def change(request: Request, who: Engineer, drive_id: DriveName) -> Response:
    """Declare the drive anew, by the form's fields."""
    fields = {name: str(value) for name, value in (await request.form()).items()}
    return await run_in_threadpool(_change, request, who, drive_id, fields | {"id": drive_id})


@router.post("/drives/{drive_id}/settings/toml", dependencies=[Depends(form_of_ours)])
def change_toml(
    request: Request,
    who: Engineer,
    drive_id: DriveName,
    text: Annotated[str, Form(max_length=100_000)] = "",
    told: Annotated[str, Form(alias="seen")] = "",
) -> Response:
    """Declare the drive anew, by the text of a drive.toml."""
    before = _content(request, drive_id)
    try:
        refuse_unseen(told, before)  # first: a page that says what is wrong is one of now
        return _changed(request, who, drive_id, _parsed(text), told)
    except UnseenError as error:
        return _page_of_now(request, who, drive_id, error)
    except BadInputError as error:
        problem = str(error)
    return _page(request, who, drive_id, before, fields_of(before), text, [problem])


def _parsed(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text.replace("\r\n", "\n"))
    except (ValueError, RecursionError) as error:  # also of thousands of digits or brackets
        raise BadInputError(
            f"text that is not valid TOML ({error})",
            "drive.toml",
            "a drive's file",
            "Correct that place; text values need quotation marks.",
        ) from error


def _change(request: Request, who: Identity, drive_id: str, fields: dict[str, str]) -> Response:
    told = fields.pop("seen", "")
    before = _content(request, drive_id)
    try:
        refuse_unseen(told, before)
        return _changed(request, who, drive_id, content_of_form(fields, before), told)
    except UnseenError as error:
        return _page_of_now(request, who, drive_id, error)
    except BadInputError as error:
        kept = fields_of({}) | fields
        return _page(request, who, drive_id, before, kept, tomli_w.dumps(before), [str(error)])


def _changed(
    request: Request, who: Identity, name: str, content: dict[str, Any], told: str
) -> Response:
    service = service_of(request)
    with service.store.writing() as session:
        drive = drive_named(session, name, alone=True)
        refuse_unseen(told, content_of(drive))
        change_drive(session, who.actor, drive, content)
        if drive.tests:
            service.ask(session, who.actor, drive, None)
    afterwards = BackgroundTask(service.read_anew, name)  # many records take their time
    return RedirectResponse(f"/drives/{name}?said=saved", 303, background=afterwards)


def _content(request: Request, name: str) -> dict[str, Any]:
    with service_of(request).store.reading() as session:
        return content_of(drive_named(session, name))


def _page_of_now(
    request: Request, who: Identity, name: str, problem: UnseenError | None = None
) -> Response:
    content = _content(request, name)
    problems = [] if problem is None else [str(problem)]
    return _page(request, who, name, content, fields_of(content), tomli_w.dumps(content), problems)


def _page(
    request: Request,
    who: Identity,
    name: str,
    content: dict[str, Any],
    fields: dict[str, str],
    text: str,
    problems: list[str],
) -> Response:
    context = context_of(fields) | {
        "name": name,
        "text": text,
        "problems": problems,
        "seen": seen(content),
    }
    return render(request, "drive_settings.html", context, 422 if problems else 200, who=who)
