"""What tests say of a steady pace: how well they fit it, and of the hyperparameters under it.

The likelihood of the tests under either prior, hyperparameters integrated out, is estimated by
importance sampling from a Student distribution around draws of the posterior (Kloek & van Dijk,
Econometrica 46, 1978).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.fleet import Said
from hdprog.trend.hyperparameters import (
    Effort,
    HyperparameterDraws,
    LogDensity,
    mode_of,
    sample,
    starting_walkers,
)
from hdprog.trend.steady_pace import SteadySaid, all_steady
from hdprog.trend.wear_prior import WearPrior

_STARTS, _BURN_IN = 64, 60
_EFFORT = Effort(80, 320, 200.0)
_DRAWS = 2000
_PROPOSED, _TAILS, _WIDER = 1500, 6, 1.3
_LARGEST_ERROR = 0.5  # of log odds: a few proposals carry all weight, and their error is a guess

LoadingsOf = Callable[[FloatArray, WearPrior, np.random.Generator], FloatArray]
"""Draws the loadings' deviates (draws, 8) given the hyperparameters' (draws, k) under a prior."""


def sampled(
    log_density: LogDensity, dimensions: int, rng: np.random.Generator, first: FloatArray
) -> HyperparameterDraws:
    """Sample hyperparameters, from `first` (dimensions,) or wherever the prior's draws lead."""
    starts = np.concatenate([first[None], rng.standard_normal((_STARTS - 1, dimensions))])
    walkers = starting_walkers(log_density, mode_of(log_density, starts), rng)
    return sample(log_density, walkers, _BURN_IN, _EFFORT.steps, rng, _EFFORT)


def log_likelihood(
    log_density: LogDensity, draws: HyperparameterDraws, rng: np.random.Generator
) -> tuple[float, float]:
    """Log of the integral of a density, up to a constant of its dimensions, and its error.

    The error is infinite where the draws say nothing of it.

    Parameters
    ----------
    log_density : a unit Gaussian's, without its constant, times a likelihood
    draws : from it
    rng : source of randomness
    """
    from scipy.stats import multivariate_t

    centre, spread = draws.flat.mean(axis=0), _WIDER * np.cov(draws.flat.T)
    try:
        proposal = multivariate_t(centre, spread, df=_TAILS, seed=rng)
    except np.linalg.LinAlgError:  # draws that have hardly moved
        return -np.inf, np.inf
    points = proposal.rvs(_PROPOSED)
    log_weight = log_density(points) - proposal.logpdf(points)
    largest = float(log_weight.max())
    weight = np.exp(log_weight - largest)
    mean = float(weight.mean())
    return largest + np.log(mean), float(weight.std()) / mean / np.sqrt(_PROPOSED)


def said_by(
    draws: HyperparameterDraws, prior: WearPrior, loadings_of: LoadingsOf, rng: np.random.Generator
) -> Said:
    """What tests say, of draws under the shipped prior or under it with a steady pace."""
    chosen = draws.thinned(_DRAWS, rng)
    deviates = np.hstack([chosen, loadings_of(chosen, prior, rng)])
    size = deviates.shape[1]
    worth = min(draws.ess_bulk, draws.ess_tail, _DRAWS)
    return Said.of(deviates, np.zeros(size), np.eye(size), worth)


def steady_said(
    shipped: WearPrior,
    density_of: Callable[[WearPrior], LogDensity],
    loadings_of: LoadingsOf,
    draws: HyperparameterDraws,
    first: FloatArray,
    rng: np.random.Generator,
) -> SteadySaid | None:
    """What tests say of a steady pace; None where their log odds cannot be told.

    Parameters
    ----------
    shipped : the wear prior as its file gives it
    density_of : density of the hyperparameters' deviates under a prior
    loadings_of : draws of the loadings
    draws : of the density under the shipped prior
    first : (k,) deviates at which every density is finite
    rng : source of randomness
    """
    prior = shipped.learnt_from(all_steady(first.size + len(NAMES)))
    steady = density_of(prior)
    found = sampled(steady, first.size, rng, first)
    under_steady, error = log_likelihood(steady, found, rng)
    under_shipped, beside = log_likelihood(density_of(shipped), draws, rng)
    if not np.hypot(error, beside) < _LARGEST_ERROR:
        return None
    log_odds = under_steady - under_shipped
    return SteadySaid(said_by(found, prior, loadings_of, rng), log_odds)
