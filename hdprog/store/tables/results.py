"""Tables of what was found: every analysis is kept, so that one sees what was believed then."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import ForeignKey, Index, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from hdprog.store.tables.base import Base, Name, Word, now


class AnalysisRow(Base):
    """One run over all accepted tests of a drive; its files lie in a folder of its name."""

    __tablename__ = "analyses"
    __table_args__ = (Index("ix_analyses_drive", "drive_id", "created_at"),)

    id: Mapped[str] = mapped_column(String(36), primary_key=True)
    drive_id: Mapped[int] = mapped_column(ForeignKey("drives.id", ondelete="CASCADE"))
    job_id: Mapped[str | None] = mapped_column(String(36))
    created_at: Mapped[datetime] = mapped_column(default=now)
    hdprog_version: Mapped[Word]
    seed: Mapped[int | None]
    quick: Mapped[bool]
    converged: Mapped[bool]
    status: Mapped[Word]
    verdict: Mapped[str]
    now_hours: Mapped[float | None]


class FitRow(Base):
    """The fit of one test in one analysis: quantiles of parameters and figures, diagnostics."""

    __tablename__ = "fits"
    __table_args__ = (UniqueConstraint("analysis_id", "test_id"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    analysis_id: Mapped[str] = mapped_column(ForeignKey("analyses.id", ondelete="CASCADE"))
    test_id: Mapped[int] = mapped_column(ForeignKey("tests.id", ondelete="CASCADE"), index=True)
    converged: Mapped[bool]
    rmse_rad: Mapped[float | None]
    noise_floor_rad: Mapped[float | None]
    parameters: Mapped[dict[str, Any]]
    figures: Mapped[dict[str, Any]]
    warnings: Mapped[list[Any]]


class EffectRow(Base):
    """An effect that an analysis found beside the drive model."""

    __tablename__ = "effects"

    id: Mapped[int] = mapped_column(primary_key=True)
    analysis_id: Mapped[str] = mapped_column(
        ForeignKey("analyses.id", ondelete="CASCADE"), index=True
    )
    test_id: Mapped[int | None] = mapped_column(ForeignKey("tests.id", ondelete="CASCADE"))
    effect: Mapped[Name]


class ForecastRow(Base):
    """The forecast of one limit in one analysis; hours past the horizon are null.

    `horizon_hours` is null of analyses that earlier versions of the program recorded.
    """

    __tablename__ = "forecasts"
    __table_args__ = (UniqueConstraint("analysis_id", "position"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    analysis_id: Mapped[str] = mapped_column(ForeignKey("analyses.id", ondelete="CASCADE"))
    position: Mapped[int]
    quantity: Mapped[Word]
    threshold: Mapped[float | None]
    direction: Mapped[str | None] = mapped_column(String(40))
    at_torque_Nm: Mapped[float | None]
    now_hours: Mapped[float]
    horizon_hours: Mapped[float | None]
    already_crossed: Mapped[bool]
    inspect_before_hours: Mapped[float | None]
    probability_crossed_by_shutdown: Mapped[float | None]
    probability_crossed_by_horizon: Mapped[float | None]
    remaining_hours: Mapped[dict[str, Any]]
