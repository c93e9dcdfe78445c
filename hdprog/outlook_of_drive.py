"""The outlook of a drive: the trend over its tests, and when its limits are crossed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hdprog.data.drive_folder import DriveFolder
from hdprog.data.finished_runs import FinishedRun, FinishedRuns
from hdprog.forecast.crossing import forecast
from hdprog.inference.posterior import Posterior
from hdprog.physics.effects.base import Effect
from hdprog.results import Forecast, LoadScenario, TrendSummary
from hdprog.trend.fitting import fit_trend
from hdprog.trend.fleet import FleetPrior, Said
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.joint_refit import BESIDE, Effort
from hdprog.trend.loop_evidence import FittedLoop
from hdprog.trend.steady_pace import SteadySaid, Told, pooled_fleet
from hdprog.trend.trend import Trend
from hdprog.trend.wear_clock import hours_by_load, pace_of_load
from hdprog.trend.wear_prior import WearPrior


@dataclass(frozen=True)
class Outlook:
    """A trend in numbers, first crossings as things are, and under other loads."""

    trend: TrendSummary
    forecasts: tuple[Forecast, ...]
    scenarios: tuple[LoadScenario, ...]


def outlook(
    folder: DriveFolder,
    posteriors: tuple[Posterior, ...],
    lasting: tuple[Effect, ...],
    loads: Sequence[float],
    wear_prior: WearPrior,
    others: FinishedRuns | None,
    seeds: Sequence[np.random.SeedSequence],
    quick: bool,
) -> Outlook:
    """Fit the trend over a drive's tests and forecast its limits.

    Parameters
    ----------
    folder, posteriors : the tests and their posteriors, in the same order
    lasting : effects that wear has brought, followed as part of the state
    loads : torques to come over the torque so far, forecast from the same random numbers
    wear_prior : as its file gives it
    others : finished runs of other drives of the fleet to learn from; None for none
    seeds : of the trend, and of the forecasts
    quick : fewer draws
    """
    trend = _trend(folder, posteriors, lasting, wear_prior, others, seeds[0], quick)
    rng = np.random.default_rng(seeds[1])
    operation = posteriors[0].operation
    forecasts = forecast(trend, folder.drive, operation, rng)
    scenarios = tuple(
        LoadScenario(
            load,
            forecast(
                trend,
                folder.drive,
                operation,
                np.random.default_rng(seeds[1]),
                load_factor=pace_of_load(load),
            ),
        )
        for load in loads
    )
    summary = trend.summary(folder.drive, operation, rng)
    if summary.fleet is not None and others is not None:
        summary = replace(summary, fleet=replace(summary.fleet, left_out=others.left_out))
    return Outlook(summary, forecasts, scenarios)


def forecasts_beside(
    folder: DriveFolder,
    posteriors: tuple[Posterior, ...],
    wear_prior: WearPrior,
    others: FinishedRuns | None,
    seeds: Sequence[np.random.SeedSequence],
) -> tuple[Forecast, ...]:
    """Forecasts alone, for comparison, over posteriors without effects; from fewer draws.

    Parameters as in `outlook`.
    """
    trend = _trend(
        folder, posteriors, (), wear_prior, others, seeds[0], quick=True, joint_effort=BESIDE
    )
    rng = np.random.default_rng(seeds[1])
    return forecast(trend, folder.drive, posteriors[0].operation, rng)


def _trend(
    folder: DriveFolder,
    posteriors: tuple[Posterior, ...],
    lasting: tuple[Effect, ...],
    wear_prior: WearPrior,
    others: FinishedRuns | None,
    seed: np.random.SeedSequence,
    quick: bool,
    joint_effort: Effort | None = None,
) -> Trend:
    followed = None
    if lasting:
        found = [(one.likelihood.reduced.course.scales, one.effect_values) for one in posteriors]
        followed = FollowedEffects.of(lasting, found)
    hours = [test.service_hours for test in folder.tests]
    by_load = hours_by_load(
        hours,
        [test.mean_torque_Nm for test in folder.tests],
        [test.mean_speed_rpm for test in folder.tests],
    )
    evidence = tuple(
        FittedLoop.of(posterior, test.service_hours, test.event, test.temperature_C, load, followed)
        for test, posterior, load in zip(
            folder.tests, posteriors, by_load or [None] * len(hours), strict=True
        )
    )
    return fit_trend(
        evidence,
        posteriors[0].prior,
        wear_prior if others is None else wear_prior.learnt_from(pooled(others)),
        np.random.default_rng(seed),
        quick=quick,
        alpha=folder.drive.alpha,
        followed=followed,
        joint_effort=joint_effort,
    )


def pooled(others: FinishedRuns) -> FleetPrior:
    """Pool what other drives' tests say of wear; see `hdprog.trend.steady_pace`."""
    return pooled_fleet([run.drive_id for run in others.runs], [_told(run) for run in others.runs])


def _told(run: FinishedRun) -> Told:
    said, steady = Said(run.said.precision, run.said.information), None
    if run.steady is not None:
        beside = run.steady.said
        steady = SteadySaid(Said(beside.precision, beside.information), run.steady.log_odds)
    return Told(said, steady)
