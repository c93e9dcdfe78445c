"""Remaining life as one who knows the law and its population would forecast it.

Distribution of the first crossing given a new unit's noisy readings and that it has not failed:

* Wiener: drift and figure at the tests are Gaussian; draws are weighted by the chance that the
  bridges between them have not been past the threshold, and each goes on to the inverse Gaussian
  law (Karatzas & Shreve, Brownian Motion and Stochastic Calculus, 1991, sections 3.5.C, 4.3.C).
* gamma: a filter on a grid of the figure, for each size of unit on a grid.
* smooth laws: importance sampling of the unit's deviates, first from the population, then from a
  wide Student mixture around what that found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import fftconvolve
from scipy.special import gammainc, log_ndtr, logsumexp, ndtr
from scipy.stats import gamma as gamma_law

from tests.benchmarks.prognostics.fleets import NOW, TEST_HOURS
from tests.benchmarks.prognostics.laws import (
    PLANNED_HOURS,
    FloatArray,
    Gamma,
    Population,
    Smooth,
    Wiener,
)

_DRAWS = 4000
_FIRST, _SECOND = 100_000, 40_000
_SIZES, _CELLS = 81, 1200
_TAILS = 5.0  # degrees of freedom of the Student proposal
_PRIOR_SHARE = 0.1


@dataclass(frozen=True)
class Forecast:
    """Distribution function (times,), and how many independent draws it is worth."""

    probability: FloatArray
    worth: float


def oracle(
    population: Population, readings: FloatArray, grid: FloatArray, rng: np.random.Generator
) -> Forecast:
    """Forecast one unit.

    Parameters
    ----------
    population : the truth
    readings : (tests,) at the first of `TEST_HOURS`
    grid : (times,) service hours, that of the last reading first
    rng : source of randomness
    """
    if isinstance(population, Wiener):
        return _wiener(population, readings, grid, rng)
    if isinstance(population, Gamma):
        return _gamma(population, readings, grid, rng)
    assert isinstance(population, Smooth)
    return _smooth(population, readings, grid, rng)


def inverse_gaussian(
    remaining: FloatArray, drift: FloatArray, diffusion: float, distance: FloatArray
) -> FloatArray:
    """Chance (draws, times) that drift t + diffusion B has reached the distance by then.

    Parameters
    ----------
    remaining : (times,) t from zero on
    drift, distance : (draws,)
    diffusion : standard deviation per root of time
    """
    time = np.maximum(remaining, np.finfo(float).tiny)
    root = diffusion * np.sqrt(time)
    drift, distance = drift[:, None], distance[:, None]
    again = 2.0 * drift * distance / diffusion**2 + log_ndtr(-(drift * time + distance) / root)
    return np.asarray(ndtr((drift * time - distance) / root) + np.exp(np.minimum(again, 0.0)))


def _wiener(
    law: Wiener, readings: FloatArray, grid: FloatArray, rng: np.random.Generator
) -> Forecast:
    time = TEST_HOURS[: readings.size] / PLANNED_HOURS
    # The unknown are the drift's deviate and the figures at the tests.
    spread = law.pace * law.scatter
    mean = np.concatenate([[0.0], law.pace * time])
    moves = np.concatenate([[1.0], spread * time])
    covariance = np.outer(moves, moves)
    covariance[1:, 1:] += law.shape**2 * np.minimum.outer(time, time)
    seen = covariance[1:, 1:] + law.noise**2 * np.eye(time.size)
    gain = np.linalg.solve(seen, covariance[1:]).T
    centre = mean + gain @ (readings - mean[1:])
    left = covariance - gain @ covariance[1:]
    root = np.linalg.cholesky(left + 1e-12 * np.eye(len(left)))
    drawn = centre + rng.standard_normal((_DRAWS, mean.size)) @ root.T
    room = np.maximum(1.0 - np.column_stack([np.zeros(_DRAWS), drawn[:, 1:]]), 0.0)
    variance = law.shape**2 * np.diff(time, prepend=0.0)
    weight = np.prod(-np.expm1(-2.0 * room[:, :-1] * room[:, 1:] / variance), axis=1)
    weight /= weight.sum()
    remaining = (grid - NOW) / PLANNED_HOURS
    crossed = inverse_gaussian(remaining, law.drifts(drawn[:, 0]), law.shape, room[:, -1])
    return Forecast(weight @ crossed, float(1.0 / np.sum(weight**2)))


def _gamma(
    law: Gamma, readings: FloatArray, grid: FloatArray, rng: np.random.Generator
) -> Forecast:
    deviates = np.linspace(-5.0, 5.0, _SIZES)
    sizes = law.sizes(deviates)
    edges = np.linspace(0.0, 1.0, _CELLS + 1)
    level = 0.5 * (edges[1:] + edges[:-1])
    shapes = law.shape * np.diff(TEST_HOURS[: readings.size] / PLANNED_HOURS, prepend=0.0)
    mass = np.zeros((_SIZES, _CELLS))
    log_evidence = -0.5 * deviates**2
    for number, (shape, reading) in enumerate(zip(shapes, readings, strict=True)):
        # Steps between the middles of cells; the first begins at zero itself.
        ends = edges if number == 0 else np.concatenate([[0.0], edges[:-1] + 0.5 / _CELLS])
        step = np.diff(gamma_law.cdf(ends * law.shape / sizes[:, None], shape), axis=1)
        mass = step if number == 0 else fftconvolve(mass, step, axes=1)[:, :_CELLS]
        mass = np.maximum(mass, 0.0) * np.exp(-0.5 * ((reading - level) / law.noise) ** 2)
        total = np.maximum(mass.sum(axis=1), np.finfo(float).tiny)
        log_evidence = log_evidence + np.log(total)
        mass = mass / total[:, None]
    joint = np.exp(log_evidence - log_evidence.max())[:, None] * mass
    joint = joint.ravel() / joint.sum()
    which = rng.choice(joint.size, size=_DRAWS, p=joint)
    size, reached = sizes[which // _CELLS], level[which % _CELLS]
    still = law.shape * (1.0 - reached) / size
    time = np.maximum(law.shape * (grid - NOW) / PLANNED_HOURS, np.finfo(float).tiny)
    # A gamma variable of rising shape is past a level with the upper incomplete gamma function.
    crossed = 1.0 - gammainc(time[None, :], still[:, None])
    crossed[:, grid <= NOW] = 0.0
    return Forecast(crossed.mean(axis=0), float(_DRAWS))


def _smooth(
    law: Smooth, readings: FloatArray, grid: FloatArray, rng: np.random.Generator
) -> Forecast:
    hours = TEST_HOURS[: readings.size]

    def log_likelihood(deviates: FloatArray) -> FloatArray:
        missed = (readings - law.level(deviates, hours)) / law.noise
        alive = law.crossing(deviates) > NOW
        return np.where(alive, -0.5 * np.sum(missed**2, axis=1), -np.inf)

    first = rng.standard_normal((_FIRST, law.deviates))
    said = log_likelihood(first)
    # Tempered, so that the few best of the first draws do not make the proposal too narrow.
    weight = np.exp(0.5 * (said - said.max()))
    weight /= weight.sum()
    centre = weight @ first
    covariance = np.einsum("d,di,dj->ij", weight, first - centre, first - centre)
    root = np.linalg.cholesky(covariance + 1e-6 * np.eye(law.deviates))
    from_prior = rng.uniform(size=_SECOND) < _PRIOR_SHARE
    normal = rng.standard_normal((_SECOND, law.deviates))
    wide = np.sqrt(_TAILS / rng.chisquare(_TAILS, _SECOND))[:, None]
    second = np.where(from_prior[:, None], normal, centre + wide * normal @ root.T)
    log_weight = log_likelihood(second) + _log_normal(second)
    student = _log_student(second, centre, root)
    log_weight -= np.logaddexp(
        np.log(_PRIOR_SHARE) + _log_normal(second), np.log1p(-_PRIOR_SHARE) + student
    )
    weight = np.exp(log_weight - logsumexp(log_weight))
    crossing = law.crossing(second)
    order = np.argsort(crossing)
    passed = np.concatenate([[0.0], np.cumsum(weight[order])])
    count = np.searchsorted(crossing[order], grid, side="right")
    return Forecast(np.minimum(passed[count], 1.0), float(1.0 / np.sum(weight**2)))


def _log_normal(points: FloatArray) -> FloatArray:
    size = points.shape[1]
    return np.asarray(-0.5 * np.sum(points**2, axis=1) - 0.5 * size * np.log(2 * np.pi))


def _log_student(points: FloatArray, centre: FloatArray, root: FloatArray) -> FloatArray:
    from scipy.stats import multivariate_t

    return np.asarray(multivariate_t(centre, root @ root.T, df=_TAILS).logpdf(points))
