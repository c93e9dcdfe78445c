"""A fitted trend in numbers ready to be written, checked against each test's own posterior."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from statistics import NormalDist

import numpy as np

from hdprog.config import Drive
from hdprog.explanation import spoken_effect
from hdprog.inference.priors import Prior
from hdprog.inference.summarise import figure_requests
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.results import (
    LEVELS,
    FigureTrend,
    FleetShare,
    NotReproduced,
    Shrinkage,
    SteadyShare,
    SteadyWearSaid,
    SuddenEffect,
    TrendSummary,
    WearSaid,
    by_level,
)
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.fleet import FleetPrior, Said
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.joint_refit import RHAT_LIMIT, Met
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters
from hdprog.trend.steady_pace import Told, ToldEarly, is_steady
from hdprog.trend.temperature_effect import cooled, temperature_effect, warmth_added
from hdprog.trend.trend import Trend
from hdprog.trend.wear_coordinates import STIFFEST_TEETH
from hdprog.trend.what_tests_say import DEVIATES, what_tests_say

MODEL = (
    "one wear coordinate behind all parameters, w = (1 − exp(−κu))/κ with u = A·(hours/h)^p, whose "
    "rate may change at random and is expected to rise past the last test, until wear of the teeth "
    "ends where their first stiffness b is worn out, that of preload and friction where T_i is; "
    "loadings around the direction of Table 2, random wear, own drifts of each parameter and "
    f"remounting scatter; teeth of more than {STIFFEST_TEETH:g} times the cup's stiffness are "
    "ruled out"
)
_DRAWS = 400
_OWN_DRAWS = 400
_FLEET_DRAWS = 4000
_PAST, _AHEAD = 40, 40
_LARGEST_SHIFT = 3.5  # of the spread that the difference may have
_SLACK = 0.6  # of a test's own spread, by which the trend's mean may differ for free
_WIDEST = 2.0
_ENDS = (0.05, 0.5, 0.95)


def figure_quantiles(values: FloatArray) -> FloatArray:
    """Quantiles (levels, times) at `LEVELS` of values (draws, times)."""
    return np.asarray(np.quantile(values, LEVELS, axis=0))


def own_figures(
    test: LoopEvidence, request: FigureRequest, prior: Prior, operation: Operation
) -> FloatArray:
    """Compute a figure over (at most 400 of) a test's own posterior draws, (draws,)."""
    return figure_paths(request, _own_draws(test), prior, operation)


def _own_draws(test: LoopEvidence) -> FloatArray:
    return test.posterior[:: max(1, len(test.posterior) // _OWN_DRAWS)]


def summarise(
    trend: Trend,
    drive: Drive,
    operation: Operation,
    rng: np.random.Generator,
    early: ToldEarly | None = None,
) -> TrendSummary:
    """Put a trend into numbers.

    Parameters
    ----------
    trend : as fitted
    drive : its limits' figures are followed beside the standard ones, up to its horizon
    operation : what the figures refer to
    rng : source of randomness
    early : what could be told to other drives before the loops were sampled; found here if None

    Returns
    -------
    the summary; it names every test whose figures the trend does not reproduce
    """
    requests = figure_requests(drive, operation)
    hours = _hours(trend, drive.forecast.horizon_hours)
    coordinates = trend.paths(hours, rng, _DRAWS)
    measured = trend.measured(rng, _DRAWS)
    added, at_reference = warmth_added(trend, rng, _OWN_DRAWS), None
    if added is not None:
        own_draws = [_own_draws(test) for test in trend.tests]
        at_reference = [cooled(own, added[:, test]) for test, own in enumerate(own_draws)]
    warmth = temperature_effect(trend, requests, operation, rng, _DRAWS)
    figures: dict[str, FigureTrend] = {}
    doubtful: list[NotReproduced] = []
    for request in requests:
        of = partial(
            figure_paths,
            request,
            prior=trend.prior,
            operation=operation,
            followed=trend.followed,
        )
        own = [of(_own_draws(test)) for test in trend.tests]
        shown = own if at_reference is None else [of(draws) for draws in at_reference]
        figures[request.key] = FigureTrend(
            request.key,
            hours,
            figure_quantiles(of(coordinates)),
            np.array([test.service_hours for test in trend.tests]),
            np.stack([np.quantile(values, LEVELS) for values in shown], axis=1),
            None if warmth is None else warmth.reference_C,
        )
        doubtful += not_reproduced(request.key, own, of(measured))
    told = what_tests_say(trend, rng, early)
    return TrendSummary(
        says=_wear_said(trend, told),
        fleet=_fleet_share(trend, told.said, rng),
        model=MODEL + _beside(trend.followed),
        followed=() if trend.followed is None else trend.followed.ids,
        hyperparameters=_levels(trend.hyperparameters()),
        carried_by_prior=trend.carried_by_prior(),
        figures=figures,
        diagnostics={
            "rhat": trend.draws.rhat,
            "ess_bulk": trend.draws.ess_bulk,
            "ess_tail": trend.draws.ess_tail,
            "linearisation_steps": float(trend.mode.steps),
            **_exactness(trend.met),
        },
        converged=trend.converged,
        warnings=trend.warnings,
        temperature=warmth,
        not_reproduced=tuple(doubtful),
        sudden=_sudden(trend, measured),
    )


def _hours(trend: Trend, horizon_hours: float) -> FloatArray:
    """Service hours of a course from the first test to the horizon, where that lies ahead."""
    first, now = trend.tests[0].service_hours, trend.now_hours
    hours = np.linspace(first, now, _PAST)
    if horizon_hours > now:
        # Denser near now, where most limits are passed, than towards the horizon.
        ahead = now + (horizon_hours - now) * np.linspace(0.0, 1.0, _AHEAD + 1)[1:] ** 2
        hours = np.concatenate([hours, ahead])
        hours[-1] = horizon_hours
    if trend.breaks:
        # Read between, a course would be half-way through.
        hours = np.union1d(hours, [test.service_hours for test in trend.tests])
    return hours


def _sudden(trend: Trend, measured: FloatArray) -> tuple[SuddenEffect, ...]:
    """Followed effects that came at once, by what the tests met, (draws, tests, n)."""
    if trend.followed is None:
        return ()
    size = np.abs(np.median(measured, axis=0)[:, len(NAMES) :])
    found: dict[tuple[str, int], SuddenEffect] = {}
    for test, amplitude in trend.wear_prior.sudden:
        effect = trend.followed.owners[amplitude]
        came = bool(size[test, amplitude] > size[test - 1, amplitude])
        found.setdefault((effect, test), SuddenEffect(effect, test, came))
    return tuple(found.values())


def not_reproduced(
    key: str, own: Sequence[FloatArray], joint: FloatArray
) -> tuple[NotReproduced, ...]:
    """Find the tests whose figure the trend does not reproduce; nothing where there is none.

    The other tests may sharpen a test's figure and move it within its own spread: for two
    estimates of which one uses the other's data, the variance of the difference is the difference
    of the variances. More than that, or a spread wider than the test's own, means that the
    Gaussian that stands for the loop is wrong there.

    Parameters
    ----------
    key : the figure's name
    own : (tests) arrays of draws from each test's own posterior
    joint : (draws, tests) from the trend, scatter included
    """
    excess = np.zeros(len(own))
    for number, values in enumerate(own):
        sd, spread = float(values.std()), float(joint[:, number].std())
        shift = float(joint[:, number].mean() - values.mean())
        if sd == 0.0:  # a width where the teeth never slip is 0 in every draw
            excess[number] = 0.0 if shift == spread == 0.0 else np.inf
            continue
        allowed = np.sqrt(max(sd**2 - spread**2, 0.0) + (_SLACK * sd) ** 2)
        excess[number] = max(abs(shift) / (_LARGEST_SHIFT * allowed), spread / (_WIDEST * sd))
    tests = np.flatnonzero(excess > 1.0)
    if not tests.size:
        return ()
    worst = int(np.argmax(excess))
    seen = (tuple(np.quantile(one, _ENDS).tolist()) for one in (joint[:, worst], own[worst]))
    return (NotReproduced(key, tuple(tests.tolist()), worst, *seen),)


def _exactness(met: Met) -> dict[str, float]:
    """How far the Gaussian step was from the loops, and how well they were sampled with it."""
    found = {"pareto_k": met.pareto_k, "joint_rhat": met.rhat, "joint_ess": met.ess}
    found["joint_rhat_limit"] = None if met.rhat is None else RHAT_LIMIT
    return {name: value for name, value in found.items() if value is not None}


def _wear_said(trend: Trend, told: Told) -> WearSaid:
    """What other drives may learn."""
    said, steady = told.said, None
    if told.steady is not None:
        beside = told.steady.said
        steady = SteadyWearSaid(beside.precision, beside.information, told.steady.log_odds)
    identity = trend.wear_prior.identity
    return WearSaid(identity, DEVIATES, said.precision, said.information, steady)


def _fleet_share(trend: Trend, said: Said, rng: np.random.Generator) -> FleetShare | None:
    """How each hyperparameter in use shrinks from the shipped prior to this drive."""
    fleet, shipped = trend.wear_prior.fleet, trend.wear_prior.without_fleet()
    if fleet is None:
        return None
    none = np.zeros(len(DEVIATES)), np.eye(len(DEVIATES))
    scores = np.array([NormalDist().inv_cdf(level) for level in LEVELS])
    levels = []
    for mean, covariance in (none, said.posterior(*none)):
        deviates = mean + np.outer(scores, np.sqrt(np.diag(covariance)))
        values = Hyperparameters.of(deviates[:, : len(HYPERPARAMETERS)], shipped).named()
        levels.append(
            {name: dict(zip(LEVELS, found.tolist(), strict=True)) for name, found in values.items()}
        )
    any_drive, own = levels
    standard = rng.standard_normal((_FLEET_DRAWS, len(HYPERPARAMETERS)))
    of_fleet = _levels(Hyperparameters.of(standard, trend.wear_prior).named())
    return FleetShare(
        fleet.drives,
        {
            name: Shrinkage(any_drive[name], of_fleet[name], own[name])
            for name in trend.hyperparameters()
        },
        steady=_steady_share(trend, fleet),
    )


def _steady_share(trend: Trend, fleet: FleetPrior) -> SteadyShare | None:
    if fleet.steady is None:
        return None
    own = is_steady(trend.wear_prior.deviates(trend.met.deviates)).mean()
    return SteadyShare(len(fleet.steady.drives), fleet.chance, float(own))


def _beside(followed: FollowedEffects | None) -> str:
    if followed is None:
        return ""
    names = " and ".join(map(spoken_effect, followed.ids))
    return (
        f"; beside them the amplitude of {names}, which width, loss and lost motion over service "
        "time contain"
    )


def _levels(values: Mapping[str, FloatArray]) -> dict[str, dict[float, float]]:
    return {name: by_level(draws) for name, draws in values.items()}
