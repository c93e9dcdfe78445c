"""Settings that a record was read with: other columns or rows make other numbers of its bytes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from hdprog.store.tables import DriveRow, TestRow

_SECTIONS = ("columns", "select")
_KEY = "read_with"
_PROBLEMS = "unreadable"


def reading_of(content: Mapping[str, Any]) -> dict[str, Any]:
    """Give the part of a drive.toml that says how a record is read."""
    return {name: content[name] for name in _SECTIONS if content.get(name)}


def with_reading(quality: Mapping[str, Any], content: Mapping[str, Any]) -> dict[str, Any]:
    """Note in a read-out which settings it was made with."""
    return {**quality, _KEY: reading_of(content)}


def with_problems(quality: Mapping[str, Any], problems: Sequence[str]) -> dict[str, Any]:
    """Note in a read-out of earlier settings why those of now make none."""
    return {**quality, _PROBLEMS: list(problems)}


def is_current(quality: Mapping[str, Any], content: Mapping[str, Any]) -> bool:
    """Tell whether a read-out was made with the settings of now."""
    found = reading_of(content)
    return bool(quality.get(_KEY, found) == found)


def note_reading(session: Session, drive: DriveRow, content: Mapping[str, Any]) -> None:
    """Have read-outs say which settings they were made with, before these change.

    Those of earlier versions did not. What could not be read with the settings of until then may be
    with others.

    Parameters
    ----------
    session : of the change
    drive : whose settings are about to change
    content : of its drive.toml until then
    """
    for test in session.scalars(select(TestRow).where(TestRow.drive_id == drive.id)):
        kept = {key: value for key, value in test.quality.items() if key != _PROBLEMS}
        test.quality = kept if _KEY in kept else with_reading(kept, content)
