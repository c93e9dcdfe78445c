"""Settings of the whole service that an administrator may change."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from hdprog.store.audit import Actor, note
from hdprog.store.tables import SettingRow

_NAME = "service"


@dataclass(frozen=True)
class ServiceSettings:
    """Settings of the whole service.

    Attributes
    ----------
    title : what pages call this place, such as the plant's name
    quick : fits with fewer draws, marked as such
    """

    title: str = ""
    quick: bool = False


def service_settings(session: Session) -> ServiceSettings:
    """Look the settings up."""
    row = session.get(SettingRow, _NAME)
    return ServiceSettings() if row is None else ServiceSettings(**row.value)


def change_settings(session: Session, actor: Actor, wanted: ServiceSettings) -> None:
    """Keep new settings."""
    row = held_setting(session, _NAME, asdict(ServiceSettings()))
    before, row.value = row.value, asdict(wanted)
    note(session, actor, "settings changed", "service", before=before, after=row.value)


def held_setting(session: Session, name: str, first: dict[str, Any]) -> SettingRow:
    """Give a setting for a change, made with a first value where there is none.

    Others who want it wait until this change is done; of two who make it the first one counts.
    """
    row = session.get(SettingRow, name, with_for_update=True)
    if row is None:
        with suppress(IntegrityError), session.begin_nested():
            session.add(SettingRow(name=name, value=first))
        row = session.get_one(SettingRow, name, with_for_update=True)
    return row
