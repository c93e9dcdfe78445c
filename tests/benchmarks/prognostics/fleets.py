"""Simulated fleets: units that were tested ten times, and new ones that were seen five times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.benchmarks.prognostics.laws import LAWS, FloatArray, Law, Population

SEED = 61
TEST_HOURS = np.array([1.0, *np.arange(100.0, 1000.0, 100.0)])
"""Ten tests; the first after an hour, since some path models know no time zero."""
SEEN = 5
NOW = float(TEST_HOURS[SEEN - 1])
HORIZON = 4000.0
"""Service hours up to which crossings are looked for; one after that counts as never."""
_FINE = np.arange(0.0, HORIZON + 1.0)


@dataclass(frozen=True)
class Kind:
    """How many fleets of a size each law gets, and how many new units each fleet."""

    size: int
    fleets: int
    new: int


KINDS = (Kind(3, 64, 1), Kind(6, 18, 1), Kind(40, 2, 4))


@dataclass(frozen=True)
class NewUnit:
    """Its readings (5,) at the first test hours, and the hour of its true crossing (or inf)."""

    readings: FloatArray
    crossing: float


@dataclass(frozen=True)
class Fleet:
    """One fleet.

    Attributes
    ----------
    law, size, number : which
    population : that its units were drawn from; for the oracle alone
    others : (size, 10) readings of the units that were tested before
    new : units to forecast, none of which has failed at the last of its tests
    """

    law: str
    size: int
    number: int
    population: Population
    others: FloatArray
    new: tuple[NewUnit, ...]


def fleet(law: Law, size: int, number: int, new: int) -> Fleet:
    """Draw a fleet; its numbers hang on law, size and number alone."""
    rng = np.random.default_rng([SEED, LAWS.index(law), size, number])
    population = law.population(rng)

    def readings(path: FloatArray, count: int) -> FloatArray:
        at = TEST_HOURS[:count].astype(int)
        return np.asarray(path[at] + population.noise * rng.standard_normal(count))

    others = [readings(population.paths(rng, _FINE), TEST_HOURS.size) for _ in range(size)]
    units: list[NewUnit] = []
    while len(units) < new:
        path = population.paths(rng, _FINE)
        crossing = first_crossing(path)
        if crossing > NOW:
            units.append(NewUnit(readings(path, SEEN), crossing))
    return Fleet(law.name, size, number, population, np.array(others), tuple(units))


def first_crossing(path: FloatArray) -> float:
    """First hour at which a path on the fine grid reaches 1, straight between its hours."""
    over = np.flatnonzero(path >= 1.0)
    if over.size == 0:
        return float("inf")
    at = int(over[0])
    return float(_FINE[at - 1] + (1.0 - path[at - 1]) / (path[at] - path[at - 1]))
