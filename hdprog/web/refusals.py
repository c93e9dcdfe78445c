"""How requests are refused: JSON for programs, a page for people, the same words for both."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any
from urllib.parse import quote

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from sqlalchemy.exc import DataError, OperationalError
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse, RedirectResponse, Response

from hdprog.errors import BadInputError, no_room
from hdprog.store.drives import DriveExistsError
from hdprog.web.lookup import UnknownError
from hdprog.web.rendering import render
from hdprog.web.security.headers import dress
from hdprog.web.security.identity import (
    ForgedFormError,
    LoginNeededError,
    NotAllowedError,
    TokenNeededError,
    require_known,
)
from hdprog.web.service import NoRoomError, UnreadableError

log = logging.getLogger("hdprog.web")


def install(app: FastAPI) -> None:
    """Have the application answer its errors in words."""
    app.add_exception_handler(BadInputError, _bad_input)
    app.add_exception_handler(UnreadableError, _unreadable)
    app.add_exception_handler(UnknownError, _unknown)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(DataError, _unkept)
    app.add_exception_handler(UnicodeEncodeError, _unkept)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(LoginNeededError, _login)
    app.add_exception_handler(NotAllowedError, _not_allowed)
    app.add_exception_handler(TokenNeededError, _token)
    app.add_exception_handler(ForgedFormError, _forged)
    app.add_exception_handler(NoRoomError, _no_room)
    app.add_exception_handler(OperationalError, _no_answer)
    app.add_exception_handler(OSError, _of_the_machine)
    app.add_exception_handler(Exception, _mistake)


def refuse(
    request: Request, code: int, *problems: str, title: str | None = None, of_api: str = ""
) -> Response:
    """Answer with a refusal; `of_api` is said to programs alone."""
    if request.url.path.startswith("/api/"):
        said = " ".join([*problems, *filter(None, [of_api])])
        return JSONResponse({"detail": said, "problems": list(problems)}, code)
    return render(
        request,
        "refusal.html",
        {"title": title or _TITLES.get(code, "That did not work"), "problems": problems},
        code,
    )


def answer_to_stranger(request: Request) -> Response | None:
    """Answer a request of nobody who is known; None where somebody is."""
    try:
        require_known(request)
    except TokenNeededError as error:
        return _token(request, error)
    except LoginNeededError as error:
        return _login(request, error)
    except OperationalError as error:
        return _no_answer(request, error)
    return None


_TITLES = {
    400: "That request made no sense",
    403: "Not allowed",
    404: "Not found",
    405: "Not found",
    409: "It is there already",
    413: "Too large",
    422: "That cannot be used",
    500: "A mistake of ours",
    503: "The database does not answer",
    507: "The disk is full",
}


def _bad_input(request: Request, error: Exception) -> Response:
    return refuse(request, 409 if isinstance(error, DriveExistsError) else 422, str(error))


def _unreadable(request: Request, error: Exception) -> Response:
    assert isinstance(error, UnreadableError)
    named = any(option in text for text in error.problems for option in ("--columns", "--select"))
    return refuse(request, 422, *error.problems, of_api=_COLUMNS if named else "")


# The problems are in the words of `hdprog check`, whose options no program can give.
_COLUMNS = (
    'In this API columns and rows are named with the drive, as "columns" and "select" of its '
    "content: send all of it by PUT /api/v1/drives/{id}, with "
    '{"columns": {"torque": "HEADER:Nm"}}, say, and then the record again.'
)


def _unknown(request: Request, error: Exception) -> Response:
    return refuse(request, 404, str(error))


def _invalid(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    words = []
    for one in error.errors():
        if one["loc"][0] == "path":  # an address that nothing can have: no rule to explain
            return refuse(
                request,
                404,
                f"address: found nothing called {str(one.get('input'))[:80]!r}; expected a name "
                "that a page or an answer gave. Look it up there.",
            )
        words.append(_invalid_part(one))
    return refuse(request, 422, *words)


def _invalid_part(one: Mapping[str, Any]) -> str:
    """Say of one part of a request where it is, what it was, should be, and what to do."""
    place = " ".join(str(part) for part in one["loc"])
    match one["type"]:
        case "json_invalid":
            return (
                f"body, character {one['loc'][-1] + 1}: found text that is not valid JSON "
                f"({one['ctx']['error']}); expected one JSON object. Correct that place."
            )
        case "missing":
            return f"{place}: found nothing; expected it to be given. Add it."
        case "model_attributes_type":  # what no header calls JSON arrives as mere text
            return (
                f"{place}: found {_shown(one)}; expected one JSON object. Send one, with the "
                "header Content-Type: application/json."
            )
    return f"{place}: found {_shown(one)}; expected otherwise: {one['msg']}. Correct it."


def _shown(one: Mapping[str, Any]) -> str:
    return repr(one.get("input"))[:80]


def _unkept(request: Request, error: Exception) -> Response:
    return refuse(
        request,
        422,
        "request: found a value that the database cannot keep, such as text with the sign NUL or a "
        "number beyond all use; expected text as people write it. Nothing was changed. Take it out "
        "and send the rest again.",
    )


def _http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    cause = error.__cause__
    if isinstance(cause, OSError) and no_room(cause):  # as a form was put down, before it is used
        return _of_the_machine(request, cause)
    found, to_do = "nothing to do", ""
    if error.status_code == 404:
        found = "nothing at this address"
        to_do = " Expected was one that a page or an answer gave: look it up there."
    if error.status_code == 400:
        found = "a request that is not in the form it says to be"
        to_do = (
            " Expected was a whole one, with names of usual length: correct it and send it again."
        )
    words = f"{request.method} {request.url.path}: found {found} ({error.detail}).{to_do}"
    answer = refuse(request, error.status_code, words)
    answer.headers.update(error.headers or {})
    return answer


def _login(request: Request, error: Exception) -> Response:
    if request.method == "GET":
        address = quote(request.url.path)  # a drive's name may hold spaces; no address does
        return RedirectResponse(f"/login?next={quote(address)}", 303)
    # A form is gone with the session: a bare login would pass for having done what it asked.
    return RedirectResponse("/login?said=expired", 303)


def _not_allowed(request: Request, error: Exception) -> Response:
    assert isinstance(error, NotAllowedError)
    return refuse(
        request,
        403,
        f"This needs the role {error.needed}, which the account or token in use does not have. Ask "
        "an administrator for it.",
    )


def _token(request: Request, error: Exception) -> Response:
    answer = refuse(
        request,
        401,
        "Authorization: found no valid token; expected 'Bearer TOKEN'. Make one with "
        "`hdprog token add NAME`.",
    )
    answer.headers["www-authenticate"] = "Bearer"
    return answer


def _forged(request: Request, error: Exception) -> Response:
    return refuse(
        request,
        403,
        "This form was not on a page of this server, or the page was opened before the last login. "
        "Go back, load the page again and send the form once more.",
        title="The form has expired",
    )


def _no_room(request: Request, error: Exception) -> Response:
    return refuse(request, 507, str(error))


def _no_answer(request: Request, error: Exception) -> Response:
    assert isinstance(error, OperationalError)
    if no_room(error):
        return _of_the_machine(request, error)
    log.error("the database does not answer: %s", error.orig)
    return refuse(
        request,
        503,
        "database: found no answer from it; expected one, as the server's log tells whoever runs "
        "it. What was accepted before is safe. Look in a minute whether this was done, and do it "
        "again if not.",
    )


def _of_the_machine(request: Request, error: Exception) -> Response:
    full = no_room(error)
    if full is None:
        raise error
    log.error("no room on the disk: %s", error)
    return refuse(
        request,
        507,
        f"disk: found no room where records are kept ({full}); expected some. "
        "Whoever runs the server must make room. What was taken in before is kept; send the rest "
        "again.",
    )


def _mistake(request: Request, error: Exception) -> Response:
    answer = refuse(
        request,
        500,
        "hdprog met a mistake of its own. Nothing that was accepted is lost. The server's log says "
        "more; please report it.",
    )
    dress(answer.headers, request.scope)  # it is given outside of all that was added to the app
    return answer
