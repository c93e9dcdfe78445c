"""Settings: one's own password; for administrators accounts, tokens and the service."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Form, Path, Request
from starlette.responses import RedirectResponse, Response

from hdprog.errors import BadInputError
from hdprog.store import accounts
from hdprog.store.audit import note
from hdprog.store.logins import CHECKED_ALONE, TOO_OFTEN, count_failure, throttled
from hdprog.store.settings import ServiceSettings, change_settings, service_settings
from hdprog.store.tables import TokenRow, UserRow
from hdprog.web.rendering import render
from hdprog.web.security.identity import (
    SESSION,
    Admin,
    Identity,
    NotAllowedError,
    Viewer,
    form_of_ours,
)
from hdprog.web.seen import refuse_unseen, seen
from hdprog.web.service import service_of

router = APIRouter()
_OURS = [Depends(form_of_ours)]
_Number = Annotated[int, Path(ge=1, le=2**31 - 1)]  # of a row: more is no integer to PostgreSQL


@router.get("/settings")
def settings_page(request: Request, who: Viewer) -> Response:
    """Show the settings."""
    return _page(request, who)


@router.post("/settings/password", dependencies=_OURS)
def change_password(
    request: Request,
    who: Viewer,
    old: Annotated[str, Form(max_length=2000)] = "",
    new: Annotated[str, Form(max_length=2000)] = "",
) -> Response:
    """Change one's own password."""
    service = service_of(request)
    with CHECKED_ALONE:
        with service.store.reading() as session:
            if throttled(session, who.name, who.address):
                return _page(request, who, TOO_OFTEN, status=429)
            user = accounts.find_user(session, who.name)
        right = accounts.verify(user, old)
        if not right:
            with service.store.writing() as session:
                count_failure(session, who.name, who.address)
                note(session, who.actor, "wrong password", who.name)
    if user is None or not right:
        return _page(request, who, "Your password: found another than the one in use. Try again.")
    try:
        with service.store.writing() as session:
            accounts.set_password(session, who.actor, session.get_one(UserRow, user.id), new)
    except BadInputError as error:
        return _page(request, who, str(error))
    response = RedirectResponse("/login?said=password", 303)
    response.delete_cookie(SESSION)
    return response


@router.post("/settings/service", dependencies=_OURS)
def change_service(
    request: Request,
    who: Admin,
    title: Annotated[str, Form(max_length=80)] = "",
    quick: Annotated[str, Form()] = "",
) -> Response:
    """Change the settings of the service."""
    with service_of(request).store.writing() as session:
        change_settings(session, who.actor, ServiceSettings(title.strip(), bool(quick)))
    return RedirectResponse("/settings?said=saved", 303)


@router.post("/settings/users", dependencies=_OURS)
def add_user(
    request: Request,
    who: Admin,
    name: Annotated[str, Form(max_length=200)] = "",
    password: Annotated[str, Form(max_length=2000)] = "",
    role: Annotated[str, Form()] = "viewer",
) -> Response:
    """Make an account."""
    try:
        with service_of(request).store.writing() as session:
            accounts.add_user(session, who.actor, name.strip(), password, accounts.role_named(role))
    except BadInputError as error:
        return _page(request, who, str(error), user=(name, role))
    return RedirectResponse("/settings?said=saved#users", 303)


@router.post("/settings/users/{number}", dependencies=_OURS)
def change_user(
    request: Request,
    who: Admin,
    number: _Number,
    role: Annotated[str, Form()] = "viewer",
    disabled: Annotated[str, Form()] = "",
    told: Annotated[str, Form(alias="seen")] = "",
) -> Response:
    """Give an account another role, or switch it off or on."""
    try:
        with service_of(request).store.writing() as session:
            user = session.get(UserRow, number)
            if user is not None:
                refuse_unseen(told, (user.role, user.disabled))
                wanted = accounts.role_named(role)
                accounts.change_user(session, who.actor, user, wanted, disabled=bool(disabled))
    except BadInputError as error:
        return _page(request, who, str(error))
    return RedirectResponse("/settings?said=saved#users", 303)


@router.post("/settings/tokens", dependencies=_OURS)
def add_token(
    request: Request,
    who: Admin,
    name: Annotated[str, Form(max_length=200)] = "",
    role: Annotated[str, Form()] = "engineer",
) -> Response:
    """Make a token and show it, this once."""
    try:
        with service_of(request).store.writing() as session:
            wanted = accounts.role_named(role)
            text = accounts.add_token(session, who.actor, name.strip(), wanted)
    except BadInputError as error:
        return _page(request, who, str(error), program=(name, role))
    return _page(request, who, token=text)


@router.post("/settings/tokens/{number}/revoke", dependencies=_OURS)
def revoke_token(request: Request, who: Admin, number: _Number) -> Response:
    """Make a token worthless."""
    with service_of(request).store.writing() as session:
        token = session.get(TokenRow, number)
        if token is not None and token.revoked_at is None:
            accounts.revoke_token(session, who.actor, token)
    return RedirectResponse("/settings?said=saved#tokens", 303)


def _page(
    request: Request,
    who: Identity,
    problem: str | None = None,
    token: str | None = None,
    status: int = 422,
    *,
    user: tuple[str, str] = ("", "engineer"),
    program: tuple[str, str] = ("", "engineer"),
) -> Response:
    """Show the settings; `user` and `program` are name and role that stand in their forms."""
    service = service_of(request)
    if token is not None and not who.may("admin"):
        raise NotAllowedError("admin")
    with service.store.reading() as session:
        context = {
            "problem": problem,
            "token": token,
            "new_user": user,
            "new_token": program,
            "service": service_settings(session),
            "roles": accounts.ROLES,
            "least_password": accounts.LEAST_PASSWORD,
            "users": accounts.users(session) if who.may("admin") else [],
            "seen": seen,
            "tokens": accounts.tokens(session) if who.may("admin") else [],
        }
    return render(request, "settings.html", context, status if problem else 200, who=who)
