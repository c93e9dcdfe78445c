"""Accounts and tokens: who may do what."""

from __future__ import annotations

import hashlib
import re
import secrets
from collections.abc import Sequence
from typing import Literal, get_args

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from sqlalchemy import select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from hdprog.errors import BadInputError
from hdprog.store.audit import Actor, note
from hdprog.store.tables import SessionRow, TokenRow, UserRow
from hdprog.store.tables.base import now

Role = Literal["viewer", "engineer", "admin"]
ROLES: tuple[Role, ...] = get_args(Role)
"""What each may do: look; also make drives and upload; also manage accounts and settings."""

LEAST_PASSWORD = 10
_MOST_PASSWORD = 1024  # Argon2 of a novel would be a way to keep the server busy
_NAME = re.compile(r"[\w.@+\-]{1,60}")
_hasher = PasswordHasher()


def role_named(text: str) -> Role:
    """Read a role.

    Raises
    ------
    BadInputError
        for any other word
    """
    for role in ROLES:
        if role == text:
            return role
    raise BadInputError(f"the role {text!r}", "role", "one of " + ", ".join(ROLES), "Choose one.")


def add_user(session: Session, actor: Actor, name: str, password: str, role: Role) -> UserRow:
    """Make an account.

    Raises
    ------
    BadInputError
        for a name that is taken or cannot be, or a password that is too short
    """
    _require_name(name, "account")
    if find_user(session, name) is not None:
        raise _taken(name)
    user = UserRow(name=name, password_hash=_hashed(password), role=role)
    session.add(user)
    try:
        session.flush()
    except IntegrityError as error:  # somebody else made it at the same moment
        raise _taken(name) from error
    note(session, actor, "user added", name, role=role)
    return user


def _require_name(name: str, whose: str) -> None:
    if not _NAME.fullmatch(name):
        raise BadInputError(
            f"the name {name!r}",
            whose,
            "1 to 60 letters, digits or any of . _ @ + -",
            "Choose such a name.",
        )


def _taken(name: str) -> BadInputError:
    return BadInputError(
        f"the name {name} a second time",
        "account",
        "a name that is free",
        "Choose another; `hdprog user password NAME` gives an account a new password.",
    )


def set_password(session: Session, actor: Actor, user: UserRow, password: str) -> None:
    """Give an account a new password and log it out everywhere.

    Raises
    ------
    BadInputError
        for a password that is too short or too long
    """
    user.password_hash = _hashed(password)
    _log_out(session, user)
    note(session, actor, "password changed", user.name)


def change_user(
    session: Session, actor: Actor, user: UserRow, role: Role, *, disabled: bool
) -> None:
    """Give an account another role, or switch it off or on; either logs it out.

    Raises
    ------
    BadInputError
        where nobody would be left to manage accounts
    """
    leaves = (role != "admin" or disabled) and user.role == "admin"
    if leaves and not [one for one in _administrators_alone(session) if one != user.id]:
        raise BadInputError(
            f"{user.name} as the only administrator",
            "account",
            "another account with the role admin",
            "Make another administrator first.",
        )
    user.role, user.disabled = role, disabled
    _log_out(session, user)
    note(session, actor, "user changed", user.name, role=role, disabled=disabled)


def _administrators_alone(session: Session) -> Sequence[int]:
    """Give the numbers of who manages accounts; others who change one wait until this is done.

    Two administrators who demote each other in one instant would leave none.
    """
    asked = select(UserRow.id).where(UserRow.role == "admin", UserRow.disabled.is_(False))
    return session.scalars(asked.order_by(UserRow.id).with_for_update()).all()


def find_user(session: Session, name: str) -> UserRow | None:
    """Find an account by its name."""
    return session.scalar(select(UserRow).where(UserRow.name == name))


def users(session: Session) -> Sequence[UserRow]:
    """Give all accounts by name."""
    return session.scalars(select(UserRow).order_by(UserRow.name)).all()


def verify(user: UserRow | None, password: str) -> bool:
    """Tell whether a password is an account's; as slow for an account that there is not."""
    known = user is not None and not user.disabled
    stored = user.password_hash if user is not None and known else _nobody()
    try:
        _hasher.verify(stored, password[:_MOST_PASSWORD])
    except (VerificationError, InvalidHashError):
        return False
    return known


def add_token(session: Session, actor: Actor, name: str, role: Role) -> str:
    """Make a token of the API and give its text, which is not kept.

    Raises
    ------
    BadInputError
        for a name that cannot be
    """
    _require_name(name, "token")
    text = f"hdp_{secrets.token_urlsafe(32)}"
    session.add(TokenRow(name=name, digest=digest(text), role=role))
    note(session, actor, "token added", name, role=role)
    return text


def find_token(session: Session, text: str) -> TokenRow | None:
    """Find the token of a text, unless it was revoked."""
    return session.scalar(
        select(TokenRow).where(TokenRow.digest == digest(text), TokenRow.revoked_at.is_(None))
    )


def tokens(session: Session) -> Sequence[TokenRow]:
    """Give all tokens, the newest first."""
    return session.scalars(select(TokenRow).order_by(TokenRow.id.desc())).all()


def revoke_token(session: Session, actor: Actor, token: TokenRow) -> None:
    """Make a token worthless."""
    token.revoked_at = now()
    note(session, actor, "token revoked", token.name)


def digest(secret: str) -> str:
    """Give what is kept of a secret of 256 random bits."""
    return hashlib.sha256(secret.encode()).hexdigest()


def _hashed(password: str) -> str:
    if not LEAST_PASSWORD <= len(password) <= _MOST_PASSWORD:
        raise BadInputError(
            f"a password of {len(password)} characters",
            "account",
            f"{LEAST_PASSWORD} to {_MOST_PASSWORD} characters",
            "Choose a longer one, such as four words."
            if len(password) < LEAST_PASSWORD
            else "Choose a shorter one.",
        )
    return _hasher.hash(password)


def _log_out(session: Session, user: UserRow) -> None:
    for row in session.scalars(select(SessionRow).where(SessionRow.user_id == user.id)):
        session.delete(row)


_nobodys_hash = ""


def _nobody() -> str:
    """Give a hash that no password has, made once, of today's cost."""
    global _nobodys_hash
    if not _nobodys_hash:
        _nobodys_hash = _hasher.hash(secrets.token_hex(16))
    return _nobodys_hash
