"""Temperature of the tests as a covariate: a warmer drive has another loop, and is no more worn.

Where tests differ in temperature, what test j meets is

    x(t_j) + β·δ_j + e_j,    δ_j = (θ_j − θ_ref)/10 K,    β ~ N(mean, diag(sd²)),

and the course x is the drive's at θ_ref, the mean of the temperatures that are given. β is new with
a replaced drive, as its loadings are. A test whose temperature is not known is taken at θ_ref with
δ_j ~ N(0, s²), s the spread of the others: its part g = β·δ_j is taken for a Gaussian of the same
second moment, C = s²(mean·meanᵀ + diag(sd²)), and integrated out of the loop's likelihood,

    Λ ← (I + ΛC)⁻¹Λ,    η ← (I + ΛC)⁻¹η.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.information import Linearised
from hdprog.physics.parameters import FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.observation import Observations
from hdprog.trend.wear_prior import WearPrior

STEP_K = 10.0
"""Kelvin by which temperature counts."""


@dataclass(frozen=True)
class Temperatures:
    """How warm a drive was at each time.

    Attributes
    ----------
    reference_C : θ_ref in °C
    spread : s, standard deviation of the temperatures that are given, in steps of 10 K
    warmth : (times,) δ in steps of 10 K; zero where it is not known
    unknown : (times,) whether it is not known
    """

    reference_C: float
    spread: float
    warmth: FloatArray
    unknown: NDArray[np.bool_]

    @staticmethod
    def of(tests: Sequence[LoopEvidence]) -> Temperatures | None:
        """Temperatures of tests; None where none are given, or all that are given are equal."""
        each = np.array([_number(test.temperature_C) for test in tests])
        unknown = np.isnan(each)
        given = each[~unknown]
        if not given.size or np.ptp(given) == 0:
            return None
        reference = float(given.mean())
        warmth = np.where(unknown, 0.0, (each - reference) / STEP_K)
        return Temperatures(reference, float(given.std()) / STEP_K, warmth, unknown)

    def along(self, which: NDArray[np.intp]) -> Temperatures:
        """Along times (times,), each a test or −1 for a further time, which is at θ_ref."""
        seen = which >= 0
        return replace(
            self,
            warmth=np.where(seen, self.warmth[which], 0.0),
            unknown=seen & self.unknown[which],
        )

    def draw_warmth(
        self, temperature_C: float | None, rng: np.random.Generator, draws: int
    ) -> FloatArray:
        """δ (draws, 1) of a test to come; drawn where its temperature is not known."""
        if temperature_C is None:
            return self.spread * rng.standard_normal((draws, 1))
        return np.full((draws, 1), (temperature_C - self.reference_C) / STEP_K)


def _number(temperature_C: float | None) -> float:
    return np.nan if temperature_C is None else temperature_C


@dataclass(frozen=True)
class Warming:
    """What temperature does to a state from one time to the next.

    Attributes
    ----------
    mean, variance : (n,) of β
    warmth : (times,) δ
    warmed : (times,) increment of δ, which starts from zero with each drive
    doubt : (times,) variance of a δ that is not known; else zero
    """

    mean: FloatArray
    variance: FloatArray
    warmth: FloatArray
    warmed: FloatArray
    doubt: FloatArray

    @staticmethod
    def of(found: Temperatures, begins: NDArray[np.bool_], wear_prior: WearPrior) -> Warming:
        """From temperatures along times, and where new drives begin (times,)."""
        before = np.where(begins, 0.0, np.roll(found.warmth, 1))
        return Warming(
            wear_prior.warmer_mean,
            wear_prior.warmer_sd**2,
            found.warmth,
            found.warmth - before,
            np.where(found.unknown, found.spread**2, 0.0),
        )

    def upto(self, times: int) -> Warming:
        """Keep the first few times only."""
        return replace(
            self,
            warmth=self.warmth[:times],
            warmed=self.warmed[:times],
            doubt=self.doubt[:times],
        )

    @property
    def unknown_part(self) -> FloatArray:
        """(times, n, n) C, zero where the temperature is known."""
        second_moment = np.outer(self.mean, self.mean) + np.diag(self.variance)
        return np.asarray(self.doubt[:, None, None] * second_moment)


@dataclass(frozen=True)
class SeenTests:
    """Loops as the trend takes them, in order, with what temperatures that are not known add.

    Attributes
    ----------
    loops : (tests) linearised
    scales : (n,) relative size of the scatter
    unknown_part : (tests, n, n) C; None where all temperatures are known, or none counts
    """

    loops: Sequence[Linearised]
    scales: FloatArray
    unknown_part: FloatArray | None

    @staticmethod
    def of(
        loops: Sequence[Linearised], tests: Sequence[LoopEvidence], wear_prior: WearPrior
    ) -> SeenTests:
        """From linearised loops of tests."""
        found, part = Temperatures.of(tests), None
        if found is not None and found.unknown.any():
            start = np.zeros(len(tests), dtype=bool)
            part = Warming.of(found, start, wear_prior).unknown_part
        return SeenTests(loops, wear_prior.scales, part)

    @cached_property
    def observations(self) -> Observations:
        """Observations of x(t) + β·δ, known δ."""
        loops = self.loops
        if self.unknown_part is not None:
            loops = [_behind(*each) for each in zip(loops, self.unknown_part, strict=True)]
        return Observations.of(loops, self.scales)

    def draw_measured(
        self, states: FloatArray, scatter: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Draw what the tests met given states (draws, tests, n) and loops: scatter and g added."""
        met = self.observations.draw_measured(states, scatter, rng)
        if self.unknown_part is None:
            return met
        for number, (loop, part) in enumerate(zip(self.loops, self.unknown_part, strict=True)):
            if not part.any():
                continue
            at = met[:, number]
            left = part @ np.linalg.inv(np.eye(len(part)) + loop.precision @ part)
            strength, axes = np.linalg.eigh(0.5 * (left + left.T))
            noise = rng.standard_normal(at.shape) * np.sqrt(np.maximum(strength, 0.0))
            mean = (loop.information - at @ loop.precision) @ left.T
            met[:, number] = at + mean + noise @ axes.T
        return met


def _behind(loop: Linearised, part: FloatArray) -> Linearised:
    """The loop's information on what it would have met without g ~ N(0, C)."""
    if not part.any():
        return loop
    matrix = np.eye(len(part)) + loop.precision @ part
    precision = np.linalg.solve(matrix, loop.precision)
    return Linearised(
        np.asarray(0.5 * (precision + precision.T)),
        np.asarray(np.linalg.solve(matrix, loop.information)),
        loop.log_likelihood,
    )
