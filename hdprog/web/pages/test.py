"""A test: its record, its fit and its report."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from fastapi import APIRouter, Depends, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import RedirectResponse, Response

from hdprog.errors import BadInputError
from hdprog.service.same_drive import without_question
from hdprog.store import analyses, jobs
from hdprog.store.drives import content_of
from hdprog.store.readings import is_current
from hdprog.store.right_drive import answer_doubt, open_doubt, right_drive_said
from hdprog.store.uploads import accept, facts_of, remove
from hdprog.web.facts import read_facts
from hdprog.web.lookup import test_named, test_to_change
from hdprog.web.names import TestName
from hdprog.web.rendering import render_of_drive
from hdprog.web.security.identity import Engineer, Identity, Viewer, form_of_ours
from hdprog.web.seen import UnseenError, refuse_unseen, seen
from hdprog.web.service import service_of

router = APIRouter()
# A page that was opened earlier may still show the form: it must not bring a test back, nor let a
# record count that nobody has looked at.
_NOT_ACCEPTED = {
    "removed": (
        "test: found one that was removed; expected one that counts. Upload its record again if it "
        "shall count."
    ),
    "preview": (
        "test: found a record that waits for somebody to look at it; expected one that was "
        "accepted. Accept or discard it on the page of records that wait."
    ),
}


@router.get("/tests/{test_id}")
def test_page(request: Request, who: Viewer, test_id: TestName) -> Response:
    """Show a test."""
    return _page(request, who, test_id, None)


@router.post("/tests/{test_id}", dependencies=[Depends(form_of_ours)])
async def change(request: Request, who: Engineer, test_id: TestName) -> Response:
    """Change what was said of a test, remove it, or say that it is the right drive's."""
    texts = {name: str(value) for name, value in (await request.form()).items()}
    work = _answer if "right_drive" in texts else _change
    return await run_in_threadpool(work, request, who, test_id, texts)


def _answer(request: Request, who: Identity, test_id: str, texts: dict[str, str]) -> Response:
    """Take down that a record is its drive's; nothing has to be analysed again for it."""
    try:
        with service_of(request).store.writing() as session:
            test = test_to_change(session, test_id)
            other = _NOT_ACCEPTED.get(test.state)
            doubt = open_doubt(test, content_of(test.drive))
            if other is None and doubt is not None:
                refuse_unseen(texts.get("asked", ""), doubt)
                answer_doubt(session, who.actor, test)
    except UnseenError as error:
        return _page(request, who, test_id, str(error))
    if other is not None:
        return _page(request, who, test_id, other, 409)
    return RedirectResponse(f"/tests/{test_id}?said=saved", 303)


def _change(request: Request, who: Identity, test_id: str, texts: dict[str, str]) -> Response:
    service = service_of(request)
    try:
        facts = None if "remove" in texts else read_facts(texts)
        with service.store.writing() as session:
            test = test_to_change(session, test_id)
            drive = test.drive
            other = _NOT_ACCEPTED.get(test.state)
            if other is None:
                refuse_unseen(texts.get("seen", ""), facts_of(test))
                if facts is None:
                    remove(session, who.actor, test)
                    service.compare_anew(session, drive)
                else:
                    accept(session, who.actor, test, facts)
                job = service.ask(session, who.actor, drive, None)
    except UnseenError as error:
        return _page(request, who, test_id, str(error))
    except BadInputError as error:
        return _page(request, who, test_id, str(error), texts=texts)
    if other is not None:
        return _page(request, who, test_id, other, 409)
    return RedirectResponse(f"/jobs/{job.id}?said=saved", 303)


def _page(
    request: Request,
    who: Identity,
    test_id: str,
    problem: str | None,
    status: int = 422,
    *,
    texts: Mapping[str, str] = MappingProxyType({}),
) -> Response:
    """Show a test; `texts` stand in the fields of its form in place of what holds."""
    service = service_of(request)
    with service.store.reading() as session:
        test = test_named(session, test_id)
        drive = test.drive
        content = content_of(drive)
        fit = analyses.newest_fit(session, drive, test)
        stale = not is_current(test.quality, content)
        doubt = None if stale else test.quality.get("doubt")
        answer = None if test.state == "preview" else right_drive_said(test)
        settled = answer is not None or test.state == "removed"
        context = {
            "test": test,
            "drive": drive,
            "fit": fit,
            "job": jobs.job_of_test(session, test),
            "problem": problem,
            "texts": texts,
            "seen": texts.get("seen") or seen(facts_of(test)),
            "stale": stale,
            "doubt": without_question(doubt) if doubt and settled else doubt,
            "asked": seen(doubt),
            "answer": answer,
            "has_picture": service.store.files.find_picture(test.sha256, drive.id) is not None,
        }
    status = status if problem else 200
    return render_of_drive(request, "test.html", content, context, status, who=who)
