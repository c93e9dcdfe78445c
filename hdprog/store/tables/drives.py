"""Tables of drives, their limits, their tests and what was done to them."""

from __future__ import annotations

from datetime import date, datetime
from typing import Any

from sqlalchemy import JSON, ForeignKey, Index, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column, relationship

from hdprog.store.tables.base import Base, Digest, Name, Word, now

UNTESTED = 5
"""Rank of a drive without a result: after those of which something is known."""


class DriveRow(Base):
    """A drive: what its drive.toml declares, and its newest verdict for the fleet's page.

    `settings` is the content of drive.toml without the limits, which have a table of their own.
    The columns from `status` on repeat what the newest analysis says, so that a page of thousands
    of drives needs one table.
    """

    __tablename__ = "drives"
    __table_args__ = (
        Index("ix_drives_worst_first", "rank", "rank_hours", "id"),
        Index("ix_drives_status", "status"),
    )

    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[Name] = mapped_column(unique=True)
    settings: Mapped[dict[str, Any]]
    created_at: Mapped[datetime] = mapped_column(default=now)
    created_by: Mapped[Name]
    status: Mapped[Word] = mapped_column(default="untested")
    provisional: Mapped[bool] = mapped_column(default=False)
    label: Mapped[str] = mapped_column(String(200), default="No test yet")
    sentence: Mapped[str] = mapped_column(default="")
    rank: Mapped[int] = mapped_column(default=UNTESTED)
    rank_hours: Mapped[float] = mapped_column(default=0.0)
    remaining: Mapped[dict[str, Any]] = mapped_column(default=dict)
    sparkline: Mapped[dict[str, Any]] = mapped_column(default=dict)
    warnings: Mapped[int] = mapped_column(default=0)
    tests: Mapped[int] = mapped_column(default=0)
    last_test_at: Mapped[datetime | None]
    last_test_hours: Mapped[float | None]
    analysis_id: Mapped[str | None] = mapped_column(String(36))

    limits: Mapped[list[LimitRow]] = relationship(
        order_by="LimitRow.position", cascade="all, delete-orphan"
    )


class LimitRow(Base):
    """A limit of a drive, in the order in which drive.toml has them."""

    __tablename__ = "limits"
    __table_args__ = (UniqueConstraint("drive_id", "position"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    drive_id: Mapped[int] = mapped_column(ForeignKey("drives.id", ondelete="CASCADE"))
    position: Mapped[int]
    quantity: Mapped[Word]
    direction: Mapped[Word]
    threshold: Mapped[float]
    at_torque_Nm: Mapped[float | None]


class TestRow(Base):
    """A test: the record as it came, what was read out of it, and what the user said of it.

    `label` is its name in the drive, as in tests.csv; `uid` its name in the whole store. The
    record's bytes lie in the folder of files under their SHA-256. `state` is "preview" until a
    person has looked at the read-out, then "accepted"; "removed" tests stay on record.
    """

    __tablename__ = "tests"
    __test__ = False  # not a pytest class
    __table_args__ = (
        UniqueConstraint("drive_id", "label"),
        UniqueConstraint("drive_id", "sha256", name="uq_tests_one_file_once"),
        Index("ix_tests_drive_state", "drive_id", "state", "service_hours"),
    )

    id: Mapped[int] = mapped_column(primary_key=True)
    uid: Mapped[Name] = mapped_column(unique=True)
    drive_id: Mapped[int] = mapped_column(ForeignKey("drives.id", ondelete="CASCADE"))
    label: Mapped[Name]
    state: Mapped[Word] = mapped_column(default="preview")
    file_name: Mapped[str] = mapped_column(String(200))
    sha256: Mapped[Digest]
    size: Mapped[int]
    service_hours: Mapped[float | None]
    tested_on: Mapped[date | None]
    temperature_C: Mapped[float | None]
    note: Mapped[str | None]
    mean_torque_Nm: Mapped[float | None]
    mean_speed_rpm: Mapped[float | None]
    quality: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    uploaded_at: Mapped[datetime] = mapped_column(default=now)
    uploaded_by: Mapped[Name]

    drive: Mapped[DriveRow] = relationship()
    event: Mapped[EventRow | None] = relationship(cascade="all, delete-orphan", lazy="joined")


class EventRow(Base):
    """What was done to a drive before a test: regreased, reassembled or replaced."""

    __tablename__ = "events"

    id: Mapped[int] = mapped_column(primary_key=True)
    test_id: Mapped[int] = mapped_column(ForeignKey("tests.id", ondelete="CASCADE"), unique=True)
    kind: Mapped[Word]
