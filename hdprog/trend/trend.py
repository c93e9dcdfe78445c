"""The trend of one drive over all its tests, and paths of its state drawn from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive
from hdprog.config.drive import DEFAULT_ALPHA
from hdprog.inference.priors import Prior
from hdprog.physics.figures import Operation
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.results import TrendSummary
from hdprog.trend.ahead import level_off, simulate_ahead
from hdprog.trend.bend import Bend
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.hyperparameters import (
    HyperparameterDraws,
)
from hdprog.trend.relinearise import JointMode
from hdprog.trend.smoother import at_reference, draw, per_step_of_warmth
from hdprog.trend.state_space import HYPERPARAMETERS, LOAD_SHARE, Hyperparameters, Steps, Timeline
from hdprog.trend.temperature import SeenTests
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior, to_loop
from hdprog.trend.wear_prior import WearPrior

_B = NAMES.index("b")
_FARTHEST = 15.0  # prior spreads of a coordinate from its prior mean: figures stay finite


@dataclass(frozen=True)
class Paths:
    """Paths of a drive's state, and how far each may have wandered between their times.

    Attributes
    ----------
    hours : (times,) service hours
    states : (draws, times, n) wear coordinates
    direction : (n,) along which wear wanders
    shared : (draws, times) variance added along it since the time before
    own : (draws, times, n) variance added to each coordinate alone
    warmer : (draws, n) what 10 K add to a state after the last test; zero where temperature does
        not count, else the states are those at the reference temperature
    """

    hours: FloatArray
    states: FloatArray
    direction: FloatArray
    shared: FloatArray
    own: FloatArray
    warmer: FloatArray

    @property
    def coordinates(self) -> FloatArray:
        """(draws, times, n) the loops' unconstrained coordinates, then followed amplitudes."""
        return to_loop(self.states)


@dataclass(frozen=True)
class Trend:
    """A fitted trend.

    Attributes
    ----------
    tests : in order of service hours
    prior, wear_prior : of the loops and of the wear
    clock : from service hours to the hours by which wear counts
    mode : where the loops were linearised
    draws : of the hyperparameters, as standard normal deviates
    warnings : in words
    alpha : gear-tooth angle in rad
    followed : effects whose amplitudes are part of the state
    """

    tests: tuple[LoopEvidence, ...]
    prior: Prior
    wear_prior: WearPrior
    clock: ServiceClock
    mode: JointMode
    draws: HyperparameterDraws
    warnings: tuple[str, ...]
    alpha: float = DEFAULT_ALPHA
    followed: FollowedEffects | None = None

    @property
    def _state_prior(self) -> StatePrior:
        return StatePrior.of(self.prior, self.wear_prior)

    @property
    def now_hours(self) -> float:
        """Service hours of the last test."""
        return self.tests[-1].service_hours

    @property
    def converged(self) -> bool:
        """Whether both the sampling and the linearisation came to rest."""
        return self.draws.converged and self.mode.converged

    def paths(
        self,
        hours: FloatArray,
        rng: np.random.Generator,
        draws: int = 1000,
        load_factor: float = 1.0,
    ) -> FloatArray:
        """Coordinates (draws, times, n) of paths of the drive's state; see `wandering_paths`."""
        return self.wandering_paths(hours, rng, draws, load_factor).coordinates

    def wandering_paths(
        self,
        hours: FloatArray,
        rng: np.random.Generator,
        draws: int = 1000,
        load_factor: float = 1.0,
    ) -> Paths:
        """Paths of the drive's state, without the scatter of remounting.

        Parameters
        ----------
        hours : (times,) service hours, rising, before and after now
        rng : source of randomness
        draws : number of paths
        load_factor : pace of the clock past the last test over the pace so far, e.g. 0.8³ at
            80 % torque
        """
        values = Hyperparameters.of(self.draws.thinned(draws, rng), self.wear_prior)
        clock = self.clock.slowed(load_factor)
        timeline, which = Timeline.of(self.tests, clock, self.wear_prior, hours)
        steps = Steps.of(timeline, values, self._state_prior, self.wear_prior)
        behind = int(np.flatnonzero(which >= 0)[-1]) + 1
        seen = self._seen.observations(which[:behind])
        states, carried = draw(steps.upto(behind), seen, values.scatter, rng)
        centre, farthest = steps.initial_mean, _FARTHEST * np.sqrt(steps.initial_variance)
        states = states + self._put_back(states, values.scatter, which[:behind], rng)
        states = np.clip(states, centre - farthest, centre + farthest)
        now = at_reference(steps, states[:, -1], carried, behind - 1)
        ahead = simulate_ahead(steps, rng, (now, carried), behind, self.wear_prior.rate_ahead)
        ahead = np.clip(ahead, centre - farthest, centre + farthest)
        present = now[:, _B]
        floor = self.wear_prior.floor(np.exp(present), rng.uniform(size=present.size))
        ahead[..., _B] = level_off(present, ahead[..., _B], floor)
        return Paths(
            np.asarray(hours, dtype=float),
            np.concatenate([states, ahead], axis=1)[:, which < 0],
            self.wear_prior.loading_mean,
            steps.shared[:, which < 0],
            steps.own[:, which < 0],
            per_step_of_warmth(steps, carried),
        )

    def measured(self, rng: np.random.Generator, draws: int = 500) -> FloatArray:
        """Draw what each test met, scatter and warmth included, given all: (draws, tests, n)."""
        values = Hyperparameters.of(self.draws.thinned(draws, rng), self.wear_prior)
        states, _ = self._at_tests(values, rng)
        measured = self._seen.draw_measured(states, values.scatter, rng)
        return to_loop(measured + self._bent(measured))

    def deviates(self, rng: np.random.Generator, draws: int) -> tuple[FloatArray, FloatArray]:
        """Draw deviates of the wear prior's file: hyperparameters (draws, k), loadings (draws, 8).

        Both of one draw belong together.
        """
        prior, chosen = self.wear_prior, self.draws.thinned(draws, rng)
        _, carried = self._at_tests(Hyperparameters.of(chosen, prior), rng)
        departure = carried[:, : prior.loading_mean.size] - prior.loading_mean
        return prior.deviates(chosen), (departure / prior.loading_sd)[:, : len(NAMES)]

    def hyperparameters(self) -> Mapping[str, FloatArray]:
        """Draws of the hyperparameters by name, (draws,) each."""
        named = Hyperparameters.of(self.draws.flat, self.wear_prior).named()
        return {name: named[name] for name in self._in_use}

    def carried_by_prior(self) -> tuple[str, ...]:
        """Hyperparameters whose spread the tests hardly narrowed: by less than a fifth."""
        spread = self.draws.flat.std(axis=0)
        wide = dict(zip(HYPERPARAMETERS, spread**2 > 0.64, strict=True))
        return tuple(name for name in self._in_use if wide[name])

    @property
    def _in_use(self) -> tuple[str, ...]:
        by_load = self.clock.by_load
        return tuple(name for name in HYPERPARAMETERS if by_load or name != LOAD_SHARE)

    def summary(self, drive: Drive, operation: Operation, rng: np.random.Generator) -> TrendSummary:
        """Put the trend into numbers ready to be written; see `hdprog.trend.summary.summarise`."""
        from hdprog.trend.summary import summarise

        return summarise(self, drive, operation, rng)

    @property
    def _seen(self) -> SeenTests:
        return SeenTests.of(self.mode.loops, self.tests, self.wear_prior)

    def _at_tests(
        self, values: Hyperparameters, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Draw states (draws, tests, n) at the tests, and what the last carries (draws, k)."""
        timeline, _ = Timeline.of(self.tests, self.clock, self.wear_prior)
        steps = Steps.of(timeline, values, self._state_prior, self.wear_prior)
        return draw(steps, self._seen.observations(), values.scatter, rng)

    def _bent(self, measured: FloatArray) -> FloatArray:
        """Correction of draws (draws, tests, n) onto the ridge of each loop."""
        spread, scale = self._state_prior.sd, self.prior.softplus_scale
        each = [
            Bend(point, loop, spread, self.alpha, scale).correction(measured[:, number])
            for number, (point, loop) in enumerate(
                zip(self.mode.points, self.mode.loops, strict=True)
            )
        ]
        return np.stack(each, axis=1)

    def _put_back(
        self,
        states: FloatArray,
        scatter: FloatArray,
        which: NDArray[np.intp],
        rng: np.random.Generator,
    ) -> FloatArray:
        """Correction (draws, times, n) that puts states back on the loops' ridges.

        It is found at the tests and goes straight from one to the next between them.
        """
        at = np.flatnonzero(which >= 0)
        found = self._bent(self._seen.draw_measured(states[:, at], scatter, rng))
        after = np.clip(np.searchsorted(at, np.arange(which.size)), 0, at.size - 1)
        before = np.maximum(after - 1, 0)
        gap = np.maximum(at[after] - at[before], 1)
        share = np.clip((np.arange(which.size) - at[before]) / gap, 0.0, 1.0)[:, None]
        return np.asarray((1 - share) * found[:, before] + share * found[:, after])
