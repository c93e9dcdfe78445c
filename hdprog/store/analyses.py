"""Analyses: recorded whole in one transaction, and looked up again."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session, aliased

from hdprog.store.files import Files
from hdprog.store.tables import (
    AnalysisRow,
    DriveRow,
    EffectRow,
    FitRow,
    ForecastRow,
    JobRow,
    TestRow,
)
from hdprog.store.tables.drives import UNTESTED


@dataclass(frozen=True)
class Standing:
    """What a list of drives shows of one, as the newest analysis has it; see `DriveRow`."""

    status: str
    provisional: bool
    label: str
    sentence: str
    rank: int
    rank_hours: float
    remaining: Mapping[str, Any]
    sparkline: Mapping[str, Any]
    warnings: int


def record(
    session: Session,
    job: JobRow,
    number: str,
    tests: Sequence[TestRow],
    summary: Mapping[str, Any],
    standing: Standing,
) -> str | None:
    """Keep an analysis whose files are in place.

    Parameters
    ----------
    session : of the change
    job : that asked for it
    number : of the analysis; names its folder
    tests : that it was made of
    summary : content of its summary.json
    standing : what the fleet's page shall show

    Returns
    -------
    str or None
        The number of the analysis that it takes the place of.
    """
    drive = session.get_one(DriveRow, job.drive_id)
    provenance, forecasts = summary["provenance"], summary["forecast"]
    session.add(
        AnalysisRow(
            id=number,
            drive_id=drive.id,
            job_id=job.id,
            hdprog_version=summary["hdprog_version"],
            seed=summary["seed"],
            quick=provenance["quick"],
            converged=summary["converged"],
            status=standing.status,
            verdict=summary["verdict"]["text"],
            now_hours=forecasts[0]["now_hours"] if forecasts else None,
        )
    )
    session.flush()
    by_label = {test.label: test.id for test in tests}
    for one in summary["tests"]:
        session.add(_fit(number, by_label[one["test_id"]], one))
        session.add_all(
            EffectRow(analysis_id=number, test_id=by_label[one["test_id"]], effect=effect)
            for effect in one["effects"]
        )
    session.add_all(_forecast(number, *numbered) for numbered in enumerate(forecasts))
    before, drive.analysis_id = drive.analysis_id, number
    drive.status, drive.provisional = standing.status, standing.provisional
    drive.label, drive.sentence = standing.label, standing.sentence
    drive.rank, drive.rank_hours = standing.rank, standing.rank_hours
    drive.remaining, drive.sparkline = dict(standing.remaining), dict(standing.sparkline)
    drive.warnings = standing.warnings
    return before


def _fit(analysis: str, test: int, one: Mapping[str, Any]) -> FitRow:
    return FitRow(
        analysis_id=analysis,
        test_id=test,
        converged=one["converged"],
        rmse_rad=one["rmse_rad"],
        noise_floor_rad=one["noise_floor_rad"],
        parameters=one["parameters"],
        figures=one["figures"],
        warnings=one["warnings"],
    )


def _forecast(analysis: str, position: int, one: Mapping[str, Any]) -> ForecastRow:
    return ForecastRow(
        analysis_id=analysis,
        position=position,
        quantity=one["quantity"],
        threshold=one["limit"],
        direction=one["direction"],
        at_torque_Nm=one["at_torque_Nm"],
        now_hours=one["now_hours"],
        horizon_hours=one["horizon_hours"],
        already_crossed=one["already_crossed"],
        inspect_before_hours=one["inspect_before_hours"],
        probability_crossed_by_shutdown=one["probability_crossed_by_shutdown"],
        probability_crossed_by_horizon=one["probability_crossed_by_horizon"],
        remaining_hours=one["remaining_hours"],
    )


def summary_of(files: Files, number: str) -> dict[str, Any]:
    """Read the summary of an analysis."""
    text = (files.analysis(number) / "summary.json").read_text("utf-8")
    content: dict[str, Any] = json.loads(text)
    return content


def has_converged(session: Session, number: str | None) -> bool:
    """Whether every fit and the trend of an analysis did; of none there is nothing that did not."""
    found = None if number is None else session.get(AnalysisRow, number)
    return found is None or found.converged


def newest_fit(session: Session, drive: DriveRow, test: TestRow) -> FitRow | None:
    """Find the fit of a test in the newest analysis of its drive."""
    if drive.analysis_id is None:
        return None
    return session.scalar(
        select(FitRow).where(FitRow.analysis_id == drive.analysis_id, FitRow.test_id == test.id)
    )


def analyses_of(session: Session, drive: DriveRow, count: int) -> Sequence[AnalysisRow]:
    """Give the analyses of a drive, the newest first."""
    asked = (
        select(AnalysisRow)
        .where(AnalysisRow.drive_id == drive.id)
        .order_by(AnalysisRow.created_at.desc())
        .limit(count)
    )
    return session.scalars(asked).all()


def first_limits(session: Session, analyses: Sequence[AnalysisRow]) -> dict[str, ForecastRow]:
    """Give, by analysis, the forecast of the first of all limits as it was believed then."""
    rows = session.scalars(
        select(ForecastRow)
        .where(ForecastRow.analysis_id.in_([one.id for one in analyses]))
        .order_by(ForecastRow.position)
    )
    found: dict[str, ForecastRow] = {}
    for row in rows:
        if row.analysis_id not in found or row.quantity == "first_limit":
            found[row.analysis_id] = row
    return found


def overtaken(session: Session, drives: Iterable[DriveRow]) -> dict[int, AnalysisRow]:
    """Give, by number of drive, the newest analyses that lack what was uploaded or changed since.

    Whether the job of that waits, is under way, failed or was called off: what such an analysis
    says of its drive is of before.
    """
    its_job, later = aliased(JobRow), aliased(JobRow)
    asked = (
        select(AnalysisRow)
        .join(DriveRow, DriveRow.analysis_id == AnalysisRow.id)
        .join(its_job, its_job.id == AnalysisRow.job_id)
        .join(later, later.drive_id == AnalysisRow.drive_id)
        .where(
            DriveRow.id.in_([drive.id for drive in drives]),
            later.state != "done",
            later.created_at > its_job.started_at,
        )
    )
    return {one.drive_id: one for one in session.scalars(asked)}


def forget_standing(drive: DriveRow) -> None:
    """Show a drive as one without tests; its analyses stay on record."""
    drive.analysis_id, drive.status, drive.provisional = None, "untested", False
    drive.label, drive.sentence, drive.warnings = "No test yet", "", 0
    drive.rank, drive.rank_hours, drive.remaining, drive.sparkline = UNTESTED, 0.0, {}, {}


def fits_of(session: Session, drive: DriveRow) -> Sequence[FitRow]:
    """Give the fits of the newest analysis of a drive."""
    return session.scalars(select(FitRow).where(FitRow.analysis_id == drive.analysis_id)).all()


def forecasts_of(session: Session, drive: DriveRow) -> Sequence[ForecastRow]:
    """Give the forecasts of the newest analysis of a drive, in the order of its limits."""
    return session.scalars(
        select(ForecastRow)
        .where(ForecastRow.analysis_id == drive.analysis_id)
        .order_by(ForecastRow.position)
    ).all()
