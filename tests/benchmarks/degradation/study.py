"""Fit the first readings of every unit, forecast the rest, and score it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.forecast.crossing import first_crossing, forecast_hours
from hdprog.forecast.limits import Margins
from hdprog.forecast.scores import covers, crps, sample_crps
from hdprog.physics.parameters import FloatArray
from hdprog.results import LEVELS
from hdprog.trend.fitting import fit_trend
from hdprog.trend.state_space import Hyperparameters
from hdprog.trend.steady_pace import Told
from hdprog.trend.trend import Trend
from hdprog.trend.wear_prior import WearPrior
from hdprog.trend.what_tests_say import what_tests_say
from tests.benchmarks.degradation.series import AT, Series, Study, readings, state_prior, wear_prior

ALONE, POOLED, LINE = "by itself", "with the other units", "straight line"
_DRAWS = 1000
_BEYOND = 2.0  # planned times up to which crossings are looked for


@dataclass(frozen=True)
class Score:
    """One unit's forecast by one method.

    Attributes
    ----------
    readings : (later readings, 3) held by 90 and 50 % intervals, absolute error or CRPS
    crossing : the same of the crossing, over the planned time; None where it lies before or is not
        known
    converged : whether the trend did
    """

    method: str
    readings: FloatArray
    crossing: FloatArray | None
    converged: bool = True


def forecasts(
    study: Study, units: Sequence[Series], seed: int
) -> Iterator[tuple[str, list[Score]]]:
    """Every unit's scores, by itself, with the others' full series, and by a straight line."""
    prior, shipped = state_prior(), wear_prior(study)
    told: list[Told] = []
    for number, unit in enumerate(units):
        rng = np.random.default_rng([seed, number, 0])
        whole = fit_trend(readings(unit, unit.times.size, prior), prior, shipped, rng, quick=True)
        told.append(what_tests_say(whole, rng))
    for number, unit in enumerate(units):
        others = [one for index, one in enumerate(told) if index != number]
        names = [str(index) for index in range(len(others))]
        scores = [
            _scored(method, study, unit, wear, np.random.default_rng([seed, number, 1]))
            for method, wear in ((ALONE, shipped), (POOLED, shipped.taught_by(names, others)))
        ]
        yield unit.unit, [*scores, _line(study, unit)]


def _scored(
    method: str, study: Study, unit: Series, wear: WearPrior, rng: np.random.Generator
) -> Score:
    prior = state_prior()
    trend = fit_trend(readings(unit, study.known, prior), prior, wear, rng, quick=True)
    later = slice(study.known, None)
    predicted = trend.paths(unit.times[later], rng, _DRAWS)[..., AT]
    predicted = predicted + _scatter(trend, predicted.shape, rng)
    rows = [
        (*_held(draws, truth), sample_crps(draws, truth))
        for draws, truth in zip(predicted.T, unit.values[later], strict=True)
    ]
    return Score(method, np.array(rows), _crossing(study, unit, trend, rng), trend.converged)


def _scatter(trend: Trend, shape: tuple[int, ...], rng: np.random.Generator) -> FloatArray:
    """What readings scatter about the state."""
    values = Hyperparameters.of(trend.draws.thinned(shape[0], rng), trend.wear_prior)
    return np.asarray(values.scatter[:, None] * rng.standard_normal(shape))


def _held(draws: FloatArray, truth: float) -> tuple[float, float]:
    low, first, third, high = np.quantile(draws, [0.05, 0.25, 0.75, 0.95])
    return float(low <= truth <= high), float(first <= truth <= third)


def _crossing(
    study: Study, unit: Series, trend: Trend, rng: np.random.Generator
) -> FloatArray | None:
    truth, now = unit.crossing(), trend.now_hours
    if not study.fails or truth <= now or not np.isfinite(truth):
        return None
    hours = forecast_hours(now, _BEYOND * study.planned)
    paths = trend.wandering_paths(hours, rng, _DRAWS)
    wander = paths.shared * paths.direction[..., AT] ** 2 + paths.own[..., AT]
    limits = [Margins(1.0 - paths.states[..., AT], wander)]
    found = first_crossing(hours, limits, survived_so_far=True)
    remaining = {
        level: None if (at := found.quantile(level)) is None else at - now for level in LEVELS
    }
    return np.array(
        [
            float(covers(remaining, 0.05, 0.95, truth - now)),
            float(covers(remaining, 0.25, 0.75, truth - now)),
            crps(found.hours, found.probability, truth) / study.planned,
        ]
    )


def _line(study: Study, unit: Series) -> Score:
    """A least-squares line through the readings that the forecast is told: one value, no spread."""
    known = slice(0, study.known)
    slope, level = np.polyfit(unit.times[known], unit.values[known], 1)
    later = slice(study.known, None)
    missed = np.abs(level + slope * unit.times[later] - unit.values[later])
    rows = np.column_stack([np.full((missed.size, 2), np.nan), missed])
    truth, now = unit.crossing(), float(unit.times[study.known - 1])
    crossing = None
    if study.fails and np.isfinite(truth) and truth > now:
        horizon = _BEYOND * study.planned
        at = float(np.clip((1.0 - level) / slope, now, horizon)) if slope > 0 else horizon
        crossing = np.array([np.nan, np.nan, abs(at - truth) / study.planned])
    return Score(LINE, rows, crossing)
