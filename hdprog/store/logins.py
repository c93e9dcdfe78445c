"""Browsers that are logged in, and passwords that were wrong too often."""

from __future__ import annotations

import secrets
import threading
from datetime import timedelta

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from hdprog.store.accounts import digest
from hdprog.store.tables import LoginFailureRow, SessionRow, UserRow
from hdprog.store.tables.base import now

TOO_OFTEN = "Too many wrong passwords of late. Wait 15 minutes, or ask an administrator."
IDLE = timedelta(hours=12)
LONGEST = timedelta(days=7)
CHECKED_ALONE = threading.Lock()
"""Held while a password is checked and counted: each check sees the wrong ones before it, and
Argon2's memory is taken once."""
_WINDOW = timedelta(minutes=15)
_MOST_FAILURES_OF_ACCOUNT = 10
_MOST_FAILURES_OF_ADDRESS = 30
_NOTED_EVERY = timedelta(minutes=1)


def open_session(session: Session, user: UserRow) -> str:
    """Log a browser in and give the text of its cookie."""
    text = secrets.token_urlsafe(32)
    session.add(SessionRow(digest=digest(text), user_id=user.id))
    session.execute(delete(SessionRow).where(SessionRow.created_at < now() - LONGEST))
    return text


def find_session(session: Session, text: str) -> SessionRow | None:
    """Find who a cookie belongs to, unless it is too old or its account switched off."""
    row = session.get(SessionRow, digest(text))
    if row is None or row.user.disabled:
        return None
    moment = now()
    if moment - row.seen_at > IDLE or moment - row.created_at > LONGEST:
        return None
    return row


def is_to_be_noted(row: SessionRow) -> bool:
    """Tell whether it is worth a write that a browser was seen again."""
    return now() - row.seen_at > _NOTED_EVERY


def close_session(session: Session, text: str) -> None:
    """Log a browser out."""
    session.execute(delete(SessionRow).where(SessionRow.digest == digest(text)))


def throttled(session: Session, name: str, address: str) -> bool:
    """Tell whether passwords were wrong too often of late for this account or from this address."""
    since = now() - _WINDOW
    for subject, most in _subjects(name, address):
        count = session.scalar(
            select(func.count())
            .select_from(LoginFailureRow)
            .where(LoginFailureRow.subject == subject, LoginFailureRow.at > since)
        )
        if (count or 0) >= most:
            return True
    return False


def count_failure(session: Session, name: str, address: str) -> None:
    """Remember that a password was wrong."""
    for subject, _ in _subjects(name, address):
        session.add(LoginFailureRow(subject=subject))
    session.execute(delete(LoginFailureRow).where(LoginFailureRow.at < now() - _WINDOW))


def _subjects(name: str, address: str) -> tuple[tuple[str, int], ...]:
    # Account and address together: a stranger cannot lock somebody out from elsewhere.
    return (
        (f"account {digest(name)[:32]} from {address}", _MOST_FAILURES_OF_ACCOUNT),
        (f"address {address}", _MOST_FAILURES_OF_ADDRESS),
    )
