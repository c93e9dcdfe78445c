"""The audit trail: who changed what, when and from where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from hdprog.store.tables import AuditRow


@dataclass(frozen=True)
class Actor:
    """Who does something: a user, a token or a command, and the address it came from."""

    name: str
    address: str | None = None


COMMAND_LINE = Actor("command line")


def note(session: Session, actor: Actor, action: str, subject: str, **details: Any) -> None:
    """Add a line to the trail, in the transaction of the change itself.

    Parameters
    ----------
    session : of the change
    actor : who
    action : what, as a verb and its object: "drive made"
    subject : of which drive, test or account
    details : what else is worth knowing, as JSON knows it
    """
    session.add(
        AuditRow(
            actor=actor.name,
            address=actor.address,
            action=action,
            subject=subject,
            details=details,
        )
    )


def trail(session: Session, *, before: int | None = None, count: int = 100) -> Sequence[AuditRow]:
    """Give the newest lines, older than the line `before` where one is given."""
    asked = select(AuditRow).order_by(AuditRow.id.desc()).limit(count)
    if before is not None:
        asked = asked.where(AuditRow.id < before)
    return session.scalars(asked).all()
