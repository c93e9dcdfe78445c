"""Table of jobs, as pages show them; the queue that hands them to workers has its own tables."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column, relationship

from hdprog.store.tables.base import Base, Name, Word, now
from hdprog.store.tables.drives import DriveRow, TestRow


class JobRow(Base):
    """An analysis that was asked for.

    `attempt` counts the workers that took it up: one that comes back late, after another took
    its place, no longer has the right to write. `lost` counts those that were killed at it, since
    a person last asked for it.
    """

    __tablename__ = "jobs"
    __table_args__ = (
        Index("ix_jobs_drive", "drive_id", "created_at"),
        Index("ix_jobs_state", "state"),
    )

    id: Mapped[str] = mapped_column(String(36), primary_key=True)
    drive_id: Mapped[int] = mapped_column(ForeignKey("drives.id", ondelete="CASCADE"))
    test_id: Mapped[int | None] = mapped_column(ForeignKey("tests.id", ondelete="CASCADE"))
    state: Mapped[Word] = mapped_column(default="queued")
    cancelled: Mapped[bool] = mapped_column(default=False)
    stage: Mapped[str] = mapped_column(String(100), default="waiting")
    progress: Mapped[float] = mapped_column(default=0.0)
    error: Mapped[str | None]
    attempt: Mapped[int] = mapped_column(default=0)
    lost: Mapped[int] = mapped_column(default=0)
    created_at: Mapped[datetime] = mapped_column(default=now)
    created_by: Mapped[Name]
    started_at: Mapped[datetime | None]
    finished_at: Mapped[datetime | None]
    analysis_id: Mapped[str | None] = mapped_column(String(36))

    drive: Mapped[DriveRow] = relationship(lazy="joined")
    test: Mapped[TestRow | None] = relationship(lazy="joined")
