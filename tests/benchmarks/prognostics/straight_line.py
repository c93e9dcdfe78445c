"""A least-squares line through the new unit's readings, with its textbook prediction interval.

The chance that a reading at hour t is past the threshold, by Student's law of the predicted reading
(Montgomery, Peck & Vining, Introduction to Linear Regression Analysis, 5th ed. 2012, section 2.5),
is taken for the chance of having crossed by then.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import t as student

from tests.benchmarks.prognostics.fleets import SEEN, TEST_HOURS
from tests.benchmarks.prognostics.laws import FloatArray
from tests.benchmarks.prognostics.method import GRID, Learnt, Told, given_survival

LINE = "straight line"


def learn(others: FloatArray, rng: np.random.Generator) -> Learnt:
    """Nothing: the line is the unit's own."""
    return Learnt(_forecast)


def _forecast(values: FloatArray, rng: np.random.Generator) -> Told:
    hours = TEST_HOURS[:SEEN]
    slope, level = np.polyfit(hours, values, 1)
    free = hours.size - 2
    variance = np.sum((values - level - slope * hours) ** 2) / free
    away = hours - hours.mean()
    spread = np.sqrt(
        variance * (1.0 + 1.0 / hours.size + (GRID - hours.mean()) ** 2 / np.sum(away**2))
    )
    past = student.cdf((level + slope * GRID - 1.0) / spread, free)
    return Told({LINE: given_survival(past)})
