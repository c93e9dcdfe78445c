"""What every forecasting method is given and gives back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hdprog.forecast.crossing import forecast_hours
from tests.benchmarks.prognostics.fleets import HORIZON, NOW
from tests.benchmarks.prognostics.laws import FloatArray

GRID = forecast_hours(NOW, HORIZON)
"""(times,) service hours at which every method gives its distribution function."""


@dataclass(frozen=True)
class Told:
    """What a method says of one unit: the distribution function of its first crossing on `GRID`.

    Attributes
    ----------
    by_name : (times,) of each of the method's variants
    converged : whether the method itself says that it came to rest
    """

    by_name: Mapping[str, FloatArray]
    converged: bool = True


Forecaster = Callable[[FloatArray, np.random.Generator], Told]
"""From a unit's readings (5,) to what is told of it."""


@dataclass(frozen=True)
class Learnt:
    """A method that has seen the other units.

    Attributes
    ----------
    forecast : of a new unit
    not_converged : of its fits to the other units, how many did not come to rest
    """

    forecast: Forecaster
    not_converged: int = 0


Method = Callable[[FloatArray, np.random.Generator], Learnt]
"""From the other units' readings (units, 10)."""


def of_crossings(crossings: FloatArray) -> FloatArray:
    """Distribution function of sampled crossings (draws,), inf for never.

    The unit is known not to have failed yet: crossings up to now are left out, as hdprog does.
    Where all of them lie there, failure is held for certain at once.
    """
    ahead = np.sort(crossings[~(crossings <= NOW)])
    if ahead.size == 0:
        return np.ones_like(GRID)
    return np.asarray(np.searchsorted(ahead, GRID, side="right") / ahead.size)


def given_survival(probability: FloatArray) -> FloatArray:
    """The same of a distribution function on `GRID` that is not told of the survival."""
    left = 1.0 - probability[0]
    if left <= 0.0:
        return np.ones_like(GRID)
    return np.asarray((np.maximum.accumulate(probability) - probability[0]) / left)
