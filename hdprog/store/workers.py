"""Which workers live: each leaves a mark now and then, so that a page can say when none does.

Clocks of the machines must agree to some seconds, as those of one plant do.
"""

from __future__ import annotations

from datetime import datetime, timedelta

from sqlalchemy import select
from sqlalchemy.orm import Session

from hdprog.store.tables import SettingRow
from hdprog.store.tables.base import now

MARK_SECONDS = 15.0
_SILENT_SECONDS = 60.0  # four marks missed
_PREFIX = "worker "


def mark(session: Session, name: str) -> None:
    """Note that a worker lives."""
    session.merge(SettingRow(name=_PREFIX + name, value={"seen": now().isoformat()}))


def forget(session: Session, name: str) -> None:
    """Note that a worker ends."""
    row = session.get(SettingRow, _PREFIX + name)
    if row is not None:
        session.delete(row)


def alive(session: Session) -> list[str]:
    """Name the workers that left a mark within the last minute."""
    marks = session.scalars(select(SettingRow).where(SettingRow.name.startswith(_PREFIX)))
    since = now() - timedelta(seconds=_SILENT_SECONDS)
    return sorted(
        row.name.removeprefix(_PREFIX)
        for row in marks
        if datetime.fromisoformat(row.value["seen"]) > since
    )
