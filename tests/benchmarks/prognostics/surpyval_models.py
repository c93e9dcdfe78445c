"""SurPyval's degradation paths and its Wiener process.

Paths: the other units' paths are the population, the new unit's readings its likelihood
(`predict_rul`); the linear path, and the path that its information criterion picks. That one is
given no first reading: its power and exponential paths refuse readings that are not positive,
which noise about zero makes. Wiener: drift and diffusion of all readings, the new unit's included,
and the first passage from its last reading.
"""

from __future__ import annotations

import warnings
from contextlib import suppress

import numpy as np
from surpyval import Exponential
from surpyval.degradation import DegradationAnalysis, DegradationModel, WienerProcess

from tests.benchmarks.prognostics.fleets import NOW, SEEN, TEST_HOURS
from tests.benchmarks.prognostics.laws import FloatArray
from tests.benchmarks.prognostics.method import GRID, Learnt, Told, of_crossings

LINEAR, BEST, WIENER = "SurPyval linear path", "SurPyval best path", "SurPyval Wiener"


def learn(others: FloatArray, rng: np.random.Generator) -> Learnt:
    """Fit the population's paths."""
    units, tests = others.shape
    hours, unit = np.tile(TEST_HOURS, (units, 1)), np.arange(units)[:, None] + np.zeros(tests)
    # The other units, and from which reading on each kind of path is given them.
    paths = {LINEAR: _paths(hours, others, unit, "linear", 0)}
    paths[BEST] = _paths(hours, others, unit, "best", 1)

    def forecast(values: FloatArray, rng: np.random.Generator) -> Told:
        seed, seen = int(rng.integers(2**31)), TEST_HOURS[:SEEN]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            told = {}
            for name, (model, first) in paths.items():
                # Some paths cannot be updated with some readings: no forecast, and counted so.
                with suppress(ValueError):
                    if model is not None:
                        found = model.predict_rul(seen[first:], values[first:], random_state=seed)
                        told[name] = of_crossings(found.samples)
            process = WienerProcess.fit(
                np.concatenate([hours.ravel(), seen]),
                np.concatenate([others.ravel(), values]),
                np.concatenate([unit.ravel(), np.full(SEEN, units)]),
                threshold=1.0,
            )
        told[WIENER] = (
            np.ones_like(GRID)
            if values[-1] >= 1.0
            else np.asarray(process.ff(GRID - NOW, y0=values[-1]))
        )
        return Told(told)

    return Learnt(forecast)


def _paths(
    hours: FloatArray, values: FloatArray, unit: FloatArray, path: str, first: int
) -> tuple[DegradationModel | None, int]:
    """Paths of a kind from a reading on; None where they cannot be fitted.

    Its life distribution plays no part in `predict_rul`; one of a single parameter can be fitted
    where few units fail.
    """
    with warnings.catch_warnings(), suppress(ValueError):
        warnings.simplefilter("ignore")  # of covariances at their bounds: scored as they are
        parts = [array[:, first:].ravel() for array in (hours, values, unit)]
        model = DegradationAnalysis.fit(*parts, threshold=1.0, path=path, distribution=Exponential)
        return model, first
    return None, first
