"""What a drive's tests say of how it wears, any prior left out: what other drives may learn."""

from __future__ import annotations

import numpy as np

from hdprog.config.drive import DEFAULT_ALPHA
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.fitting import begin_trend
from hdprog.trend.fleet import Said
from hdprog.trend.hyperparameters import LogDensity
from hdprog.trend.joint_refit import NONE
from hdprog.trend.smoother import draw
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.steady_evidence import said_by, steady_said
from hdprog.trend.steady_pace import Told, ToldEarly
from hdprog.trend.temperature import SeenTests
from hdprog.trend.trend import LinearisedTrend, Trend
from hdprog.trend.trend_density import UNWORN, density
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import WearPrior

DEVIATES: tuple[str, ...] = (*HYPERPARAMETERS, *(f"loading_{name}" for name in NAMES))
"""Hyperparameters, then changes of the coordinates per unit of wear."""
_DRAWS = 2000


def what_tests_say(trend: Trend, rng: np.random.Generator, early: ToldEarly | None = None) -> Told:
    """Likelihood of the deviates `DEVIATES` of the wear prior's file, as Gaussians.

    Parameters
    ----------
    trend : as fitted
    rng : source of randomness
    early : what `told_early` found; found here if None
    """
    early = told_early(trend, rng) if early is None else early
    return Told(_exactly(trend, rng) if early.said is None else early.said, early.steady)


def told_early(
    trend: LinearisedTrend, rng: np.random.Generator, alpha: float = DEFAULT_ALPHA
) -> ToldEarly:
    """What needs no sampling of the loops: all that is told of a steady pace.

    Where a fleet made the prior, the trend is begun anew under the shipped one, with its loops'
    Gaussians: what a fleet told is not passed on, nor where it led to.

    Parameters
    ----------
    trend : with or without its loops sampled
    rng : source of randomness
    alpha : gear-tooth angle in rad
    """
    shipped = trend.wear_prior.without_fleet()
    taught = trend.wear_prior.fleet is not None
    if taught:
        trend = begin_trend(
            trend.tests,
            trend.prior,
            shipped,
            rng,
            quick=True,
            alpha=alpha,
            followed=trend.followed,
            joint_effort=NONE,
        ).linearised
    loops, state_prior = trend.mode.loops, StatePrior.of(trend.prior, shipped)
    seen = SeenTests.of(loops, trend.tests, shipped).observations
    timeline, _ = Timeline.of(trend.tests, trend.clock, shipped)

    def density_of(prior: WearPrior) -> LogDensity:
        return density(trend.tests, loops, state_prior, prior)

    def loadings_of(deviates: FloatArray, prior: WearPrior, rng: np.random.Generator) -> FloatArray:
        values = Hyperparameters.of(deviates, prior)
        steps = Steps.of(timeline, values, state_prior, prior)
        departure = draw(steps, seen, values.scatter, rng).loadings - prior.loading_mean
        return np.asarray((departure / prior.loading_sd)[:, : len(NAMES)])

    draws = trend.draws
    said = said_by(draws, shipped, loadings_of, rng) if taught else None
    return ToldEarly(said, steady_said(shipped, density_of, loadings_of, draws, UNWORN, rng))


def _exactly(trend: Trend, rng: np.random.Generator) -> Said:
    """By the loops themselves, of a trend without a fleet."""
    size = len(DEVIATES)
    worth = min(trend.draws.ess_bulk, trend.draws.ess_tail, _DRAWS, trend.met.worth or np.inf)
    drawn = np.hstack(trend.deviates(rng, _DRAWS))
    return Said.of(drawn, np.zeros(size), np.eye(size), worth)
