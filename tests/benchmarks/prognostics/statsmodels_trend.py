"""statsmodels' local linear trend of the new unit's readings, simulated to its first crossing.

Variances by maximum likelihood; level and pace at the last reading from its filter. The series is
taken for evenly spaced: the first test, after an hour, counts as at zero.
"""

from __future__ import annotations

import warnings

import numpy as np
from statsmodels.tsa.statespace.structural import UnobservedComponents

from tests.benchmarks.prognostics.fleets import HORIZON, NOW, TEST_HOURS
from tests.benchmarks.prognostics.laws import FloatArray
from tests.benchmarks.prognostics.method import Learnt, Told, of_crossings

TREND = "statsmodels"
_DRAWS = 2000
_STEP = float(TEST_HOURS[2] - TEST_HOURS[1])


def learn(others: FloatArray, rng: np.random.Generator) -> Learnt:
    """Nothing: the trend is the unit's own."""
    return Learnt(_forecast)


def _forecast(values: FloatArray, rng: np.random.Generator) -> Told:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # five readings: it warns of its variances, we count
        found = UnobservedComponents(values, "local linear trend").fit(disp=False)
    named = dict(zip(found.model.param_names, found.params, strict=True))
    level_sd, pace_sd = np.sqrt([named["sigma2.level"], named["sigma2.trend"]])
    centre, covariance = found.filtered_state[:, -1], found.filtered_state_cov[:, :, -1]
    level, pace = rng.multivariate_normal(centre, covariance, _DRAWS, method="eigh").T
    crossing = np.where(level >= 1.0, NOW, np.inf)
    for step in range(round((HORIZON - NOW) / _STEP)):
        further = level + pace + level_sd * rng.standard_normal(_DRAWS)
        pace = pace + pace_sd * rng.standard_normal(_DRAWS)
        crosses = np.isinf(crossing) & (further >= 1.0)
        with np.errstate(all="ignore"):
            share = np.where(crosses, (1.0 - level) / (further - level), 0.0)
        crossing = np.where(crosses, NOW + (step + share) * _STEP, crossing)
        level = further
    return Told({TREND: of_crossings(crossing)}, bool(found.mle_retvals["converged"]))
