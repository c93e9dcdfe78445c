"""Laws by which the simulated figures degrade; written for this benchmark, nothing of hdprog.

A figure begins at 0 and fails at 1. Time s counts in planned lives of 1 000 h. A fleet draws its
population once; a unit is drawn from it as standard normal deviates z:

    Wiener        x = m s + d B(s),                  m = A (1 + u z1)
    gamma         x = a G(k s)/k,                    a = A exp(u z1), G of independent gamma steps
    power         x = a s^p,                         p = P + 0.1 z2
    accelerating  x = a (e^{g s} − 1)/(e^G − 1),     g = G exp(0.15 z2)
    saturating    x = L (1 − e^{−s/r}),              L = M exp(0.15 z2), r = R exp(u z1)
    change        x = a (s + (f − 1)(s − c)₊)/N,     f = F exp(0.25 z2), c = 0.2 + 0.7 Φ(z3)

    A = exp(0.15 z), u uniform in 0.1 to 0.25 for all; d uniform in 0.05 to 0.15; log k uniform from
    20 to 100; P uniform in 0.6 to 1.6; G in 1.5 to 3; M in 1.15 to 1.6; F in 1.5 to 4. R and N put
    the middle unit's failure at s = 1/A. A reading adds Gaussian noise, log-uniform by fleet from
    0.005 to 0.03.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

FloatArray = NDArray[np.float64]
PLANNED_HOURS = 1000.0
MIDDLE_CHANGE = 0.55


@dataclass(frozen=True)
class Population(ABC):
    """What all units of a fleet share.

    Attributes
    ----------
    pace : A
    scatter : u
    noise : standard deviation of a reading
    shape : what the law has beside (d, k, P, G, M or F)
    """

    pace: float
    scatter: float
    noise: float
    shape: float

    @abstractmethod
    def paths(self, rng: np.random.Generator, hours: FloatArray) -> FloatArray:
        """One unit's figure (times,) without noise at hours that rise from zero."""

    def _multiplier(self, deviates: FloatArray) -> FloatArray:
        return np.asarray(self.pace * np.exp(self.scatter * deviates))


class Wiener(Population):
    """Drift of the unit's own, diffusion of the fleet."""

    def drifts(self, deviates: FloatArray) -> FloatArray:
        """m at deviates (units,), per planned life."""
        return np.asarray(self.pace * (1.0 + self.scatter * deviates))

    def paths(self, rng: np.random.Generator, hours: FloatArray) -> FloatArray:
        steps = np.diff(hours / PLANNED_HOURS, prepend=0.0)
        drift = self.drifts(rng.standard_normal(1))[0]
        wander = self.shape * np.sqrt(steps) * rng.standard_normal(hours.size)
        return np.asarray(np.cumsum(drift * steps + wander))


class Gamma(Population):
    """Independent gamma steps times the unit's own size."""

    def sizes(self, deviates: FloatArray) -> FloatArray:
        """a at deviates (units,)."""
        return self._multiplier(deviates)

    def paths(self, rng: np.random.Generator, hours: FloatArray) -> FloatArray:
        steps = np.diff(hours / PLANNED_HOURS, prepend=0.0)
        size = self.sizes(rng.standard_normal(1))[0]
        return np.asarray(np.cumsum(rng.gamma(self.shape * steps)) * size / self.shape)


class Smooth(Population):
    """A law whose units are curves: all that is random is drawn once a unit."""

    deviates = 2

    @abstractmethod
    def level(self, deviates: FloatArray, hours: FloatArray) -> FloatArray:
        """Figures (units, times) of units with deviates (units, k)."""

    @abstractmethod
    def crossing(self, deviates: FloatArray) -> FloatArray:
        """Hours (units,) at which the curves reach 1; inf if never."""

    def paths(self, rng: np.random.Generator, hours: FloatArray) -> FloatArray:
        return self.level(rng.standard_normal((1, self.deviates)), hours)[0]


class Power(Smooth):
    def _exponents(self, deviates: FloatArray) -> FloatArray:
        return self.shape + 0.1 * deviates[:, 1]

    def level(self, deviates: FloatArray, hours: FloatArray) -> FloatArray:
        size, exponent = self._multiplier(deviates[:, 0]), self._exponents(deviates)
        return np.asarray(size[:, None] * (hours / PLANNED_HOURS) ** exponent[:, None])

    def crossing(self, deviates: FloatArray) -> FloatArray:
        size, exponent = self._multiplier(deviates[:, 0]), self._exponents(deviates)
        return np.asarray(PLANNED_HOURS * size ** (-1.0 / exponent))


class Accelerating(Smooth):
    def _growth(self, deviates: FloatArray) -> FloatArray:
        return np.asarray(self.shape * np.exp(0.15 * deviates[:, 1]))

    def level(self, deviates: FloatArray, hours: FloatArray) -> FloatArray:
        size = self._multiplier(deviates[:, 0]) / np.expm1(self.shape)
        growth = self._growth(deviates)[:, None]
        return np.asarray(size[:, None] * np.expm1(growth * hours / PLANNED_HOURS))

    def crossing(self, deviates: FloatArray) -> FloatArray:
        size = self._multiplier(deviates[:, 0]) / np.expm1(self.shape)
        return np.asarray(PLANNED_HOURS * np.log1p(1.0 / size) / self._growth(deviates))


class Saturating(Smooth):
    def _parts(self, deviates: FloatArray) -> tuple[FloatArray, FloatArray]:
        middle = -1.0 / np.log1p(-1.0 / self.shape) / self.pace
        time = middle * np.exp(self.scatter * deviates[:, 0])
        return np.asarray(self.shape * np.exp(0.15 * deviates[:, 1])), np.asarray(time)

    def level(self, deviates: FloatArray, hours: FloatArray) -> FloatArray:
        limit, time = self._parts(deviates)
        gone = -np.expm1(-(hours / PLANNED_HOURS) / time[:, None])
        return np.asarray(limit[:, None] * gone)

    def crossing(self, deviates: FloatArray) -> FloatArray:
        limit, time = self._parts(deviates)
        reached = limit > 1.0
        short = np.log1p(-1.0 / np.where(reached, limit, 2.0))
        return np.where(reached, -PLANNED_HOURS * time * short, np.inf)


class ChangeOfPace(Smooth):
    deviates = 3

    def _parts(self, deviates: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        size = self._multiplier(deviates[:, 0])
        size = size / (1.0 + (self.shape - 1.0) * (1.0 - MIDDLE_CHANGE))
        factor = self.shape * np.exp(0.25 * deviates[:, 1])
        return size, np.asarray(factor), np.asarray(0.2 + 0.7 * ndtr(deviates[:, 2]))

    def level(self, deviates: FloatArray, hours: FloatArray) -> FloatArray:
        size, factor, change = (part[:, None] for part in self._parts(deviates))
        time = hours / PLANNED_HOURS
        return np.asarray(size * (time + (factor - 1.0) * np.maximum(time - change, 0.0)))

    def crossing(self, deviates: FloatArray) -> FloatArray:
        size, factor, change = self._parts(deviates)
        after = change + (1.0 / size - change) / factor
        return np.asarray(PLANNED_HOURS * np.where(size * change >= 1.0, 1.0 / size, after))


@dataclass(frozen=True)
class Law:
    """A kind of population, and between which values its shape is drawn."""

    name: str
    kind: type[Population]
    least: float
    largest: float
    logarithmic: bool = False

    def population(self, rng: np.random.Generator) -> Population:
        """Draw what a fleet shares."""
        share = rng.uniform()
        shape = self.least + share * (self.largest - self.least)
        if self.logarithmic:
            shape = self.least * (self.largest / self.least) ** share
        noise = 0.005 * 6.0 ** rng.uniform()
        return self.kind(
            float(np.exp(0.15 * rng.standard_normal())), rng.uniform(0.1, 0.25), noise, shape
        )


LAWS = (
    Law("Wiener", Wiener, 0.05, 0.15),
    Law("gamma", Gamma, 20.0, 100.0, logarithmic=True),
    Law("power", Power, 0.6, 1.6),
    Law("accelerating", Accelerating, 1.5, 3.0),
    Law("saturating", Saturating, 1.15, 1.6),
    Law("change of pace", ChangeOfPace, 1.5, 4.0),
)
