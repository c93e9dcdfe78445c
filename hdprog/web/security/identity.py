"""Who is asking: a person with a session, or a program with a token; and what they may do."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Form, Request, Security
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer
from fastapi.security.utils import get_authorization_scheme_param
from starlette.responses import Response

from hdprog.store.accounts import ROLES, Role, find_token
from hdprog.store.audit import Actor
from hdprog.store.logins import find_session, is_to_be_noted
from hdprog.store.tables import SessionRow
from hdprog.store.tables.base import now
from hdprog.web.service import Service, service_of

SESSION, VISIT = "hdprog_session", "hdprog_visit"
_SEEN = "visit"


class LoginNeededError(Exception):
    """A page for people who are logged in."""


class NotAllowedError(Exception):
    """A person or a program that is known may not do this.

    Parameters
    ----------
    needed : the least role that may
    """

    def __init__(self, needed: Role) -> None:
        super().__init__(needed)
        self.needed = needed


class TokenNeededError(Exception):
    """A request of the API without a token that is valid."""


class ForgedFormError(Exception):
    """A form that does not carry the token of the page that it is on."""


@dataclass(frozen=True)
class Identity:
    """Who is asking.

    Attributes
    ----------
    name : of the account or the token
    role : what they may do
    address : where from
    """

    name: str
    role: Role
    address: str

    @property
    def actor(self) -> Actor:
        """Say who, for the audit trail."""
        return Actor(self.name, self.address)

    def may(self, role: Role) -> bool:
        """Tell whether a role's work is allowed."""
        return ROLES.index(self.role) >= ROLES.index(role)


def address_of(request: Request) -> str:
    """Where a request comes from; a trusted proxy's word is taken in by the server."""
    return request.client.host[:60] if request.client else "unknown"


def csrf_token(request: Request) -> str:
    """Give the token of this browser's forms, bound to its session or its visit."""
    bound = request.cookies.get(SESSION) or visit_of(request)
    secret = service_of(request).secret
    return hmac.new(secret, bound.encode(), hashlib.sha256).hexdigest()


def visit_of(request: Request) -> str:
    """Give the number of a browser's visit, made where it has none yet."""
    known = request.cookies.get(VISIT) or getattr(request.state, _SEEN, None)
    if known is None:
        known = secrets.token_urlsafe(16)
        setattr(request.state, _SEEN, known)
    return str(known)


def leave_cookie(request: Request, response: Response, name: str, value: str) -> None:
    """Give a browser a cookie that no script reads and no other site's form brings."""
    response.set_cookie(
        name, value, httponly=True, samesite="lax", secure=request.url.scheme == "https"
    )


def leave_visit(request: Request, response: Response) -> None:
    """Give a browser that came for the first time the number of its visit."""
    made = getattr(request.state, _SEEN, None)
    if made is not None:
        leave_cookie(request, response, VISIT, made)


def _person(request: Request) -> Identity:
    service = service_of(request)
    address = address_of(request)
    if not service.settings.login:
        return Identity("no login", "admin", address)
    text = request.cookies.get(SESSION)
    if text is None:
        raise LoginNeededError
    with service.store.reading() as session:
        row = find_session(session, text)
        if row is None:
            raise LoginNeededError
        found = Identity(row.user.name, _role(row.user.role), address)
        stale, digest = is_to_be_noted(row), row.digest
    if stale:
        with service.store.writing() as session:
            seen = session.get(SessionRow, digest)
            if seen is not None:
                seen.seen_at = now()
    return found


def _role(text: str) -> Role:
    return next(role for role in ROLES if role == text)


def _at_least(role: Role, identity: Identity) -> Identity:
    if not identity.may(role):
        raise NotAllowedError(role)
    return identity


def viewer(identity: Annotated[Identity, Depends(_person)]) -> Identity:
    """Let anybody with an account in."""
    return identity


def engineer(identity: Annotated[Identity, Depends(_person)]) -> Identity:
    """Let those in who may make drives and upload."""
    return _at_least("engineer", identity)


def admin(identity: Annotated[Identity, Depends(_person)]) -> Identity:
    """Let those in who may manage accounts and settings."""
    return _at_least("admin", identity)


Viewer = Annotated[Identity, Depends(viewer)]
Engineer = Annotated[Identity, Depends(engineer)]
Admin = Annotated[Identity, Depends(admin)]


def form_of_ours(request: Request, csrf: Annotated[str, Form()] = "") -> None:
    """Refuse a form that is not on a page of ours."""
    if not hmac.compare_digest(csrf.encode(), csrf_token(request).encode()):
        raise ForgedFormError


_bearer = HTTPBearer(auto_error=False, description="A token that `hdprog token add NAME` printed.")


def _program(
    request: Request,
    given: Annotated[HTTPAuthorizationCredentials | None, Security(_bearer)],
) -> Identity:
    service: Service = service_of(request)
    if given is None:
        raise TokenNeededError
    with service.store.reading() as session:
        token = find_token(session, given.credentials)
        if token is None:
            raise TokenNeededError
        found = Identity(f"token {token.name}", _role(token.role), address_of(request))
        number = token.id
        stale = token.used_at is None or (now() - token.used_at).total_seconds() > 60
    if stale:
        service.note_token_used(number)
    return found


def require_known(request: Request) -> None:
    """Ask who sends a request before any of its body is looked at.

    Raises
    ------
    TokenNeededError, LoginNeededError
        as its page or its part of the API would, where nobody does who is known
    """
    if not request.url.path.startswith("/api/"):
        _person(request)
        return
    scheme, text = get_authorization_scheme_param(request.headers.get("authorization"))
    given = HTTPAuthorizationCredentials(scheme=scheme, credentials=text)
    _program(request, given if scheme.lower() == "bearer" else None)


def reading_program(identity: Annotated[Identity, Depends(_program)]) -> Identity:
    """Let any valid token in."""
    return identity


def writing_program(identity: Annotated[Identity, Depends(_program)]) -> Identity:
    """Let tokens in that may make drives and upload."""
    return _at_least("engineer", identity)


ReadingProgram = Annotated[Identity, Depends(reading_program)]
WritingProgram = Annotated[Identity, Depends(writing_program)]
