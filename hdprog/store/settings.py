"""Settings of the whole service that an administrator may change."""

from __future__ import annotations

from dataclasses import asdict, dataclass

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
    before = asdict(service_settings(session))
    session.merge(SettingRow(name=_NAME, value=asdict(wanted)))
    note(session, actor, "settings changed", "service", before=before, after=asdict(wanted))
