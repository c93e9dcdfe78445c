"""The outlook of a drive: the trend over its tests, and when its limits are crossed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from hdprog.config import Drive
from hdprog.data.drive_folder import DriveFolder
from hdprog.data.finished_runs import FinishedRun, FinishedRuns
from hdprog.discovery.drive import brought_by_wear, lasting_effects
from hdprog.forecast.crossing import begin_forecast
from hdprog.inference.posterior import Posterior
from hdprog.physics.effects.base import Effect
from hdprog.physics.figures import Operation
from hdprog.results import Forecast, LoadScenario, TrendSummary
from hdprog.trend.fitting import TrendUnderWay, begin_trend
from hdprog.trend.fleet import Said
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.joint_refit import NONE, Effort
from hdprog.trend.loop_evidence import FittedLoop
from hdprog.trend.steady_pace import SteadySaid, Told
from hdprog.trend.sudden_steps import came_at_once
from hdprog.trend.summary import summarise
from hdprog.trend.trend import Trend
from hdprog.trend.wear_clock import load_hours_of, pace_of_load
from hdprog.trend.wear_prior import WearPrior
from hdprog.trend.what_tests_say import told_early


@dataclass(frozen=True)
class Outlook:
    """A trend in numbers, first crossings as things are, under other loads, and without effects.

    The last are there where they were asked for.
    """

    trend: TrendSummary
    forecasts: tuple[Forecast, ...]
    scenarios: tuple[LoadScenario, ...]
    without_effects: tuple[Forecast, ...] | None = None


@dataclass(frozen=True)
class OutlookUnderWay:
    """A drive whose trend may still be sampled in other processes.

    Attributes
    ----------
    drive, operation : what is declared of it, and what figures refer to
    trend : under way
    others : finished runs of other drives of the fleet to learn from; None for none
    seed : of the forecasts
    executor : follows parts of the forecasts' paths side by side; in this process if None
    """

    drive: Drive
    operation: Operation
    trend: TrendUnderWay
    others: FinishedRuns | None
    seed: np.random.SeedSequence
    executor: Executor | None

    def outlook(self, loads: Sequence[float], beside: OutlookUnderWay | None = None) -> Outlook:
        """Wait for the trend and forecast the limits.

        Parameters
        ----------
        loads : torques to come over the torque so far, forecast from the same random numbers
        beside : whose forecasts are asked for, too
        """
        rng = np.random.default_rng(self.seed)
        # Beside the processes that sample the loops.
        early = told_early(self.trend.linearised, rng.spawn(1)[0], self.drive.alpha)
        trend = self.trend.finished()
        numbers = rng.spawn(1)[0]
        under_way = self._begin(trend, rng)
        others = [
            self._begin(trend, np.random.default_rng(self.seed), pace_of_load(load))
            for load in loads
        ]
        without = None if beside is None else beside.begin_forecasts()
        # Beside the processes that follow the paths.
        summary = summarise(trend, self.drive, self.operation, numbers, early)
        if summary.fleet is not None and self.others is not None:
            fleet = replace(summary.fleet, left_out=self.others.left_out)
            said = (*summary.warnings, *self.others.doubts)
            summary = replace(summary, fleet=fleet, warnings=said)
        scenarios = zip(loads, others, strict=True)
        return Outlook(
            summary,
            under_way(),
            tuple(LoadScenario(load, forecasts()) for load, forecasts in scenarios),
            None if without is None else without(),
        )

    def begin_forecasts(self) -> Callable[[], tuple[Forecast, ...]]:
        """Wait for the trend and begin its forecasts alone."""
        return self._begin(self.trend.finished(), np.random.default_rng(self.seed))

    def _begin(
        self, trend: Trend, rng: np.random.Generator, load_factor: float = 1.0
    ) -> Callable[[], tuple[Forecast, ...]]:
        return begin_forecast(
            trend, self.drive, self.operation, rng, load_factor, executor=self.executor
        )


def effects_to_follow(
    folder: DriveFolder, posteriors: tuple[Posterior, ...], wear_prior: WearPrior
) -> tuple[Effect, ...]:
    """Lasting effects that wear has brought, then those that came at once between two tests.

    Parameters as in `begin_outlook`.
    """
    hours = [test.service_hours for test in folder.tests]
    worn = brought_by_wear(posteriors, hours, [test.event for test in folder.tests])
    found = list(worn)
    for effect in lasting_effects(posteriors):
        if effect in worn:
            continue
        evidence = _evidence(folder, posteriors, (*worn, effect))
        if effect.id in came_at_once(evidence, posteriors[0].prior, wear_prior):
            found.append(effect)
    return tuple(found)


def begin_outlook(
    folder: DriveFolder,
    posteriors: tuple[Posterior, ...],
    lasting: tuple[Effect, ...],
    wear_prior: WearPrior,
    others: FinishedRuns | None,
    seeds: Sequence[np.random.SeedSequence],
    quick: bool,
    executor: Executor | None,
    joint_effort: Effort | None = None,
) -> OutlookUnderWay:
    """Begin the trend over a drive's tests, up to its longest part, which is set going.

    Parameters
    ----------
    folder, posteriors : the tests and their posteriors, in the same order
    lasting : effects that are followed as part of the state, see `effects_to_follow`
    wear_prior : as its file gives it
    others : finished runs of other drives of the fleet to learn from; None for none
    seeds : of the trend, and of the forecasts
    quick : fewer draws
    executor : samples loops and trend in parts side by side, and follows paths; in this process
        if None
    joint_effort : of that; what `quick` says if None
    """
    evidence = _evidence(folder, posteriors, lasting)
    trend = begin_trend(
        evidence,
        posteriors[0].prior,
        wear_prior if others is None else _taught_by(others, wear_prior),
        np.random.default_rng(seeds[0]),
        quick=quick,
        alpha=folder.drive.alpha,
        followed=evidence[0].followed,
        joint_effort=joint_effort,
        executor=executor,
    )
    return OutlookUnderWay(folder.drive, posteriors[0].operation, trend, others, seeds[1], executor)


def begin_beside(
    folder: DriveFolder,
    posteriors: tuple[Posterior, ...],
    wear_prior: WearPrior,
    others: FinishedRuns | None,
    seeds: Sequence[np.random.SeedSequence],
    executor: Executor | None,
) -> OutlookUnderWay:
    """Begin forecasts for comparison, over posteriors without effects.

    Loops and trend are not sampled together: beside what the effects change, what that would
    change is little. Parameters as in `begin_outlook`.
    """
    return begin_outlook(
        folder, posteriors, (), wear_prior, others, seeds, True, executor, joint_effort=NONE
    )


def _evidence(
    folder: DriveFolder, posteriors: tuple[Posterior, ...], lasting: tuple[Effect, ...]
) -> tuple[FittedLoop, ...]:
    """What the trend takes from the tests, with the amplitudes of lasting effects in the state."""
    followed = None
    if lasting:
        found = [(one.likelihood.reduced.course.scales, one.effect_values) for one in posteriors]
        followed = FollowedEffects.of(lasting, found)
    each = zip(folder.tests, posteriors, load_hours_of(folder.tests), strict=True)
    return tuple(
        FittedLoop.of(posterior, test.service_hours, test.event, test.temperature_C, load, followed)
        for test, posterior, load in each
    )


def _taught_by(others: FinishedRuns, wear_prior: WearPrior) -> WearPrior:
    drives = [run.drive_id for run in others.runs]
    return wear_prior.taught_by(drives, [_told(run) for run in others.runs])


def _told(run: FinishedRun) -> Told:
    said, steady = Said(run.said.precision, run.said.information), None
    if run.steady is not None:
        beside = run.steady.said
        steady = SteadySaid(Said(beside.precision, beside.information), run.steady.log_odds)
    return Told(said, steady)
