"""hdprog's trend, by itself and with what it learns from the other units.

Readings enter as those of the published degradation data do, with the same wear prior.
"""

from __future__ import annotations

import numpy as np

from hdprog.trend.wear_prior import RateAhead, WearPrior
from tests.benchmarks.degradation.series import Series, Study, readings, state_prior, wear_prior
from tests.benchmarks.prognostics.fleets import TEST_HOURS
from tests.benchmarks.prognostics.laws import PLANNED_HOURS, FloatArray
from tests.benchmarks.prognostics.method import GRID, Learnt, Told
from tests.benchmarks.prognostics.scalar_trend import ScalarTrend, fit_scalar_trend, fleet_prior

POOLED, ALONE, LEVEL = "hdprog", "hdprog, no fleet", "hdprog, level pace"
_DRAWS = 2000
_LEVEL_PACE = RateAhead(spread=1.0, drift=0.0)
"""The pace past the last test wanders as it did before: no rise as gears have it is expected."""
_STUDY = Study("fleet", "", "", "", "", 0.0, 1.0, PLANNED_HOURS, 5)


def learn(others: FloatArray, rng: np.random.Generator) -> Learnt:
    """Fit every other unit by itself and pool what they say."""
    shipped = wear_prior(_STUDY)
    fits = [_fit(values, shipped, rng) for values in others]
    pooled = fleet_prior(shipped, fits, rng)

    def forecast(values: FloatArray, rng: np.random.Generator) -> Told:
        taught, alone = _fit(values, pooled, rng), _fit(values, shipped, rng)
        told = {
            POOLED: taught.crossing(GRID, rng, _DRAWS),
            LEVEL: taught.crossing(GRID, rng, _DRAWS, _LEVEL_PACE),
            ALONE: alone.crossing(GRID, rng, _DRAWS),
        }
        by_name = {name: found.probability for name, found in told.items()}
        return Told(by_name, taught.draws.converged and alone.draws.converged)

    return Learnt(forecast, sum(not fit.draws.converged for fit in fits))


def _fit(values: FloatArray, wear: WearPrior, rng: np.random.Generator) -> ScalarTrend:
    series = Series("", TEST_HOURS[: values.size], values)
    return fit_scalar_trend(readings(series, values.size, state_prior()), wear, rng)
