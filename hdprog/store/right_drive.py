"""A person's word that a record which made one doubt it is its drive's."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from sqlalchemy.orm import Session

from hdprog.store.audit import Actor, note
from hdprog.store.readings import is_current
from hdprog.store.tables import TestRow
from hdprog.store.tables.base import now

KEY = "right_drive"  # of a read-out that made one doubt it: who said so, and when


def renewed(test: TestRow, quality: Mapping[str, Any]) -> dict[str, Any]:
    """Give a new read-out of a record, with what a person said of the record itself."""
    said = test.quality.get(KEY)
    return {**quality, KEY: said} if said else dict(quality)


def right_drive_said(test: TestRow) -> tuple[str, datetime] | None:
    """Who said that a doubtful record is its drive's, and when; None where nobody has."""
    answer = test.quality.get(KEY)
    return None if answer is None else (answer["by"], datetime.fromisoformat(answer["at"]))


def open_doubt(test: TestRow, content: Mapping[str, Any]) -> str | None:
    """What makes one doubt that a record is its drive's, unless somebody has answered for it.

    Parameters
    ----------
    test : whose record it is
    content : of the drive's drive.toml; what was read with earlier settings asks nothing
    """
    if right_drive_said(test) is not None or not is_current(test.quality, content):
        return None
    doubt: str | None = test.quality.get("doubt")
    return doubt


def mark_right_drive(test: TestRow, actor: Actor) -> None:
    """Write down with a record who said that it is its drive's."""
    answer = {"by": actor.name, "at": now().isoformat(timespec="seconds")}
    test.quality = {**test.quality, KEY: answer}


def answer_doubt(session: Session, actor: Actor, test: TestRow) -> None:
    """Take down that a test which counts is its drive's."""
    mark_right_drive(test, actor)
    note(session, actor, "right drive confirmed", f"{test.drive.name} / {test.label}")
