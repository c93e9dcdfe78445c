"""Logging in and out."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import APIRouter, Depends, Form, Request
from starlette.responses import RedirectResponse, Response

from hdprog.store.accounts import find_user, verify
from hdprog.store.audit import Actor, note
from hdprog.store.logins import (
    CHECKED_ALONE,
    TOO_OFTEN,
    close_session,
    count_failure,
    open_session,
    throttled,
)
from hdprog.web.rendering import render
from hdprog.web.security.identity import (
    SESSION,
    VISIT,
    address_of,
    form_of_ours,
    leave_cookie,
)
from hdprog.web.service import service_of

router = APIRouter()
_OWN_PATH = re.compile(r"/(?![/\\])[^\\\s]*")
_WRONG = "Name and password do not go together. Check both; capitals count."


@router.get("/login")
def login_page(request: Request, next: str = "/") -> Response:
    """Show the form."""
    return render(request, "login.html", {"next": _own(next), "problem": None, "name": ""})


@router.post("/login", dependencies=[Depends(form_of_ours)])
def log_in(
    request: Request,
    name: Annotated[str, Form(max_length=200)] = "",
    password: Annotated[str, Form(max_length=2000)] = "",
    next: Annotated[str, Form(max_length=1000)] = "/",
) -> Response:
    """Check a password, and give the browser a session."""
    service, address = service_of(request), address_of(request)
    name = name.strip()
    with CHECKED_ALONE:
        with service.store.reading() as session:
            blocked = throttled(session, name, address)
            user = None if blocked else find_user(session, name)
        right = False if blocked else verify(user, password)
        if not right and not blocked:
            with service.store.writing() as session:
                count_failure(session, name, address)
                note(session, Actor(name[:100] or "nobody", address), "login failed", name[:100])
    if not right or user is None:
        context = {"next": _own(next), "problem": TOO_OFTEN if blocked else _WRONG, "name": name}
        return render(request, "login.html", context, 429 if blocked else 401)
    with service.store.writing() as session:
        text = open_session(session, user)
        note(session, Actor(user.name, address), "logged in", user.name)
    response = RedirectResponse(_own(next), 303)
    leave_cookie(request, response, SESSION, text)
    response.delete_cookie(VISIT)
    return response


@router.post("/logout", dependencies=[Depends(form_of_ours)])
def log_out(request: Request) -> Response:
    """End the browser's session."""
    with service_of(request).store.writing() as session:
        close_session(session, request.cookies.get(SESSION, ""))
    response = RedirectResponse("/login?said=out", 303)
    response.delete_cookie(SESSION)
    return response


def _own(path: str) -> str:
    """Give a path of this server; an address of another becomes the first page."""
    return path if _OWN_PATH.fullmatch(path) else "/"
