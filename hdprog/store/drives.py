"""Drives: declared, changed, listed worst first."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import func, or_, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from hdprog.config import Drive, drive_from_mapping
from hdprog.errors import BadInputError
from hdprog.inference.prior_file import require_prior
from hdprog.store.audit import Actor, note
from hdprog.store.readings import note_reading, reading_of
from hdprog.store.tables import DriveRow, LimitRow

_TAKEN = "new"
_MOST_NAME = 100


def declare(content: Mapping[str, Any]) -> Drive:
    """Read what a drive.toml, or a form or JSON of the same content, declares.

    Raises
    ------
    BadInputError
        for what `hdprog.config` refuses; for an id that is no name; for a prior that is a path,
        since a server opens no file that somebody names; for what an analysis would refuse: a prior
        that does not exist, or limits on K1 to K3 without the maker's torques
    """
    drive = drive_from_mapping(content)
    if not _is_name(drive.id):
        raise BadInputError(
            f"id = {drive.id!r}",
            "drive settings, [drive]",
            f"1 to {_MOST_NAME} letters, digits, dashes, spaces inside, or any of . _ +",
            "Rename the drive, such as cell3-axis2.",
        )
    if drive.id.lower() == _TAKEN:
        raise BadInputError(
            f"id = {drive.id!r}",
            "drive settings, [drive]",
            "another word: the page that makes drives has this one in its address",
            "Rename the drive, such as cell3-axis2.",
        )
    if drive.prior is not None and (drive.prior.endswith(".toml") or "/" in drive.prior):
        raise BadInputError(
            f"file = {drive.prior!r}",
            "drive settings, [prior]",
            "the name of a shipped prior, such as csf-25-80",
            "Leave [prior] out: the drive's model finds its prior. `hdprog prior list` shows all.",
        )
    require_prior(drive)
    return drive


def _is_name(text: str) -> bool:
    """Tell whether a text may be a drive's id: in any script, and safe in a path or an address.

    Marks that turn the direction of reading are no letters; accents typed apart from theirs are.
    """
    return (
        0 < len(text) <= _MOST_NAME
        and text.strip(" .") == text
        and not unicodedata.category(text[0]).startswith("M")  # it would stand on the sign before
        and all(
            sign in " ._+" or (kind := unicodedata.category(sign)) == "Pd" or kind[0] in "LMN"
            for sign in text
        )
    )


def declare_new(session: Session, content: Mapping[str, Any]) -> Drive:
    """Read what a drive.toml declares of a drive that is not there yet.

    Raises
    ------
    BadInputError
        as `declare`, and for an id that is taken
    """
    drive = declare(content)
    if find_drive(session, drive.id) is not None:
        raise _taken(drive.id)
    return drive


def content_of(row: DriveRow) -> dict[str, Any]:
    """Give the content of a drive's drive.toml."""
    content = dict(row.settings)
    if row.limits:
        content["limits"] = [_limit_content(limit) for limit in row.limits]
    return content


def add_drive(session: Session, actor: Actor, content: Mapping[str, Any]) -> DriveRow:
    """Make a drive of the content of a drive.toml.

    Raises
    ------
    BadInputError
        as `declare`, and for an id that is taken
    """
    drive = declare_new(session, content)
    row = DriveRow(name=drive.id, settings={}, created_by=actor.name)
    _declare(row, drive, content)
    session.add(row)
    try:
        session.flush()
    except IntegrityError as error:  # somebody else made it at the same moment
        raise _taken(drive.id) from error
    note(session, actor, "drive made", drive.id, content=content_of(row))
    return row


def change_drive(session: Session, actor: Actor, row: DriveRow, content: Mapping[str, Any]) -> None:
    """Declare a drive anew; its id stays.

    Raises
    ------
    BadInputError
        as `declare`, and for another id
    """
    drive = declare(content)
    if drive.id != row.name:
        raise BadInputError(
            f"id = {drive.id!r}", "drive settings, [drive]", f"{row.name!r}, as it was", "Keep it."
        )
    before = content_of(row)
    if reading_of(before) != reading_of(content):
        note_reading(session, row, before)
    row.limits.clear()
    session.flush()  # the new limits take the old ones' places
    _declare(row, drive, content)
    session.flush()
    note(session, actor, "drive changed", row.name, before=before, after=content_of(row))


def find_drive(session: Session, name: str, *, alone: bool = False) -> DriveRow | None:
    """Find a drive by its id.

    Parameters
    ----------
    session : for looking up, or of a change
    name : the id
    alone : others who change the drive wait until this change is done
    """
    asked = select(DriveRow).where(DriveRow.name == name)
    return session.scalar(asked.with_for_update() if alone else asked)


class DriveExistsError(BadInputError):
    """The id of a new drive is taken."""


def _taken(name: str) -> DriveExistsError:
    return DriveExistsError(
        f"a drive {name!r} already",
        "drive settings, [drive] id",
        "an id that is free",
        "Choose another id, or upload the tests to the drive that is there.",
    )


@dataclass(frozen=True)
class FleetPage:
    """A part of the fleet, worst first.

    Attributes
    ----------
    drives : of this page
    counts : number of drives by status, of the whole fleet
    found : number of drives that the search finds
    """

    drives: Sequence[DriveRow]
    counts: Mapping[str, int]
    found: int


def fleet(
    session: Session,
    *,
    page: int = 1,
    size: int = 50,
    search: str = "",
    status: str | None = None,
) -> FleetPage:
    """List drives, worst first.

    Parameters
    ----------
    session : for looking up
    page : from 1
    size : drives a page
    search : part of an id or a sentence
    status : only drives with this verdict
    """
    grouped = select(DriveRow.status, func.count()).group_by(DriveRow.status)
    counts = dict(iter(session.execute(grouped)))
    asked = select(DriveRow)
    if search:
        asked = asked.where(
            or_(
                DriveRow.name.icontains(search, autoescape=True),
                DriveRow.sentence.icontains(search, autoescape=True),
            )
        )
    if status:
        asked = asked.where(DriveRow.status == status)
    if search:
        found = session.scalar(select(func.count()).select_from(asked.subquery())) or 0
    else:
        found = counts.get(status, 0) if status else sum(counts.values())
    ordered = asked.order_by(DriveRow.rank, DriveRow.rank_hours, DriveRow.id)
    drives = session.scalars(ordered.offset((page - 1) * size).limit(size)).all()
    return FleetPage(drives, counts, found)


def _declare(row: DriveRow, drive: Drive, content: Mapping[str, Any]) -> None:
    row.settings = {name: value for name, value in content.items() if name != "limits"}
    row.limits.extend(
        LimitRow(
            position=position,
            quantity=limit.quantity,
            direction=limit.direction,
            threshold=limit.threshold,
            at_torque_Nm=limit.at_torque_Nm,
        )
        for position, limit in enumerate(drive.limits)
    )


def _limit_content(limit: LimitRow) -> dict[str, Any]:
    content: dict[str, Any] = {"quantity": limit.quantity}
    if limit.at_torque_Nm is not None:
        content["at_torque_Nm"] = limit.at_torque_Nm
    content[limit.direction] = limit.threshold
    return content
