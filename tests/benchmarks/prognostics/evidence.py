"""Chance of a unit's readings given its population, the unit's own deviates integrated out.

For many populations at once, and for a new unit given that it has not failed by `NOW`:

* Wiener: readings are Gaussian. That a new unit lived is weighed where its course most likely was:
  by the chance that the bridges between its smoothed figures have not been past the threshold.
* gamma: a filter of the figure on a grid, for sizes, shapes and noises on a grid; cubic between
  shapes and noises.
* smooth laws: importance sampling of the unit's curve (curves.py).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.interpolate import RegularGridInterpolator
from scipy.special import gammainc, logsumexp

from tests.benchmarks.prognostics.curves import curve_evidence
from tests.benchmarks.prognostics.fleets import NOW, TEST_HOURS
from tests.benchmarks.prognostics.laws import PLANNED_HOURS, FloatArray, Gamma, Law, Wiener
from tests.benchmarks.prognostics.oracle import inverse_gaussian
from tests.benchmarks.prognostics.populations import Populations

Evidence = Callable[[Populations], FloatArray]
"""From populations of the law to the log density (populations,) of one unit's readings."""
_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(15)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()
_CELL = 0.004
_LOG_SIZES = np.arange(-1.4, 1.41, 0.1)
_LOG_SHAPES = np.log(np.geomspace(20.0, 100.0, 7))
_LOG_NOISES = np.log(np.geomspace(0.005, 0.03, 9))


def unit_evidence(law: Law, readings: FloatArray, new: bool, rng: np.random.Generator) -> Evidence:
    """Evidence of one unit.

    Parameters
    ----------
    law : that the unit is held to obey
    readings : (tests,) at the first of `TEST_HOURS`
    new : whether the unit is known not to have failed by `NOW`, its last test
    rng : source of randomness
    """
    if law.kind is Wiener:
        return lambda populations: _wiener(populations, readings, new)
    if law.kind is Gamma:
        return _gamma(readings, new)
    return curve_evidence(law, readings, new, rng)


def _wiener(populations: Populations, readings: FloatArray, new: bool) -> FloatArray:
    time = TEST_HOURS[: readings.size] / PLANNED_HOURS
    pace, diffusion = populations.pace[:, None], populations.shape
    spread = populations.pace * populations.scatter
    course = (spread**2)[:, None, None] * np.outer(time, time) + (diffusion**2)[
        :, None, None
    ] * np.minimum.outer(time, time)
    seen = course + (populations.noise**2)[:, None, None] * np.eye(time.size)
    away = readings - pace * time
    solved = np.linalg.solve(seen, away[:, :, None])
    misfit = np.sum(away * solved[:, :, 0], axis=1)
    said = -0.5 * (misfit + np.linalg.slogdet(seen)[1] + time.size * np.log(2 * np.pi))
    if not new:
        return np.asarray(said)
    figures = pace * time + (course @ solved)[:, :, 0]
    room = np.maximum(1.0 - np.pad(figures, ((0, 0), (1, 0))), 1e-6)
    steps = np.diff(time, prepend=0.0)
    bridges = -np.expm1(-2.0 * room[:, 1:] * room[:, :-1] / (diffusion**2)[:, None] / steps)
    return np.asarray(said + np.log(bridges).sum(axis=1) - np.log(_wiener_lives(populations)))


def _wiener_lives(populations: Populations) -> FloatArray:
    """Chance (populations,) of not having crossed by `NOW`."""
    # Drift and distance are scaled by the diffusion, which differs from population to population.
    distance = 1.0 / populations.shape
    drifts = populations.pace * (1.0 + populations.scatter * _NODES[:, None]) * distance
    now = np.array([NOW / PLANNED_HOURS])
    crossed = [inverse_gaussian(now, drift, 1.0, distance)[:, 0] for drift in drifts]
    return np.asarray(1.0 - _WEIGHTS @ np.array(crossed))


def _gamma(readings: FloatArray, new: bool) -> Evidence:
    table = _gamma_table(readings, new)
    between = RegularGridInterpolator((_LOG_SHAPES, _LOG_NOISES), table, method="cubic")

    def evidence(populations: Populations) -> FloatArray:
        said = between(np.column_stack([np.log(populations.shape), np.log(populations.noise)]))
        deviates = _LOG_SIZES - np.log(populations.pace)[:, None]
        prior = np.exp(-0.5 * (deviates / populations.scatter[:, None]) ** 2)
        prior /= prior.sum(axis=1, keepdims=True)
        found = logsumexp(said, axis=1, b=prior)
        if new:
            sizes = np.exp(_LOG_SIZES)
            still = populations.shape[:, None] / sizes
            passed = 1.0 - gammainc((populations.shape * NOW / PLANNED_HOURS)[:, None], still)
            found -= np.log1p(-np.sum(prior * passed, axis=1))
        return np.asarray(found)

    return evidence


def _gamma_table(readings: FloatArray, new: bool) -> FloatArray:
    """Log density of the readings for shapes, noises and sizes on the grid."""
    time = TEST_HOURS[: readings.size] / PLANNED_HOURS
    top = 1.0 if new else max(float(readings.max()), 0.0) + 0.2
    levels = np.arange(0.0, top, _CELL)
    edges = np.append(0.0, levels + 0.5 * _CELL)
    length = next_fast_len(2 * levels.size, real=True)
    shape, size = np.exp(_LOG_SHAPES)[:, None, None], np.exp(_LOG_SIZES)[:, None]
    noise = np.exp(_LOG_NOISES)[:, None, None]
    total = np.zeros((_LOG_SHAPES.size, _LOG_NOISES.size, _LOG_SIZES.size))
    mass = np.zeros((*total.shape, levels.size))
    mass[..., 0] = 1.0
    steps: dict[float, FloatArray] = {}
    for duration, reading in zip(np.diff(time, prepend=0.0).round(9), readings, strict=True):
        if duration not in steps:
            shares = np.diff(gammainc(shape * duration, edges * shape / size), axis=-1)
            steps[duration] = rfft(shares, length)[:, None]
        moved = irfft(rfft(mass, length) * steps[duration], length)[..., : levels.size]
        density = np.exp(-0.5 * ((reading - levels) / noise) ** 2) / noise / np.sqrt(2 * np.pi)
        mass = np.maximum(moved, 0.0) * density
        found = np.maximum(mass.sum(axis=-1), np.finfo(float).tiny)
        total += np.log(found)
        mass = mass / found[..., None]
    return total
