"""The trend of one drive over all its tests, and paths of its state drawn from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hdprog.inference.priors import Prior
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.results import since_replaced
from hdprog.trend.ahead import simulate_ahead, within_reach, worn_ahead
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.given_measured import GivenMeasured
from hdprog.trend.hyperparameters import HyperparameterDraws
from hdprog.trend.joint_refit import Met
from hdprog.trend.kalman_filter import at_reference, per_step_of_warmth
from hdprog.trend.relinearise import JointMode
from hdprog.trend.state_space import HYPERPARAMETERS, LOAD_SHARE, Hyperparameters, Steps, Timeline
from hdprog.trend.temperature import SeenTests
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior, to_loop
from hdprog.trend.wear_prior import RateAhead, WearPrior

_LEVEL = RateAhead(spread=1.0, drift=0.0)
_PRIOR_DRAWS = 20_000


@dataclass(frozen=True)
class Paths:
    """Paths of a drive's state, and how far each may have wandered between their times.

    Attributes
    ----------
    hours : (times,) service hours
    states : (draws, times, n) wear coordinates
    direction : (draws, times, n) along which wear wanders, shorter where it nears its end
    shared : (draws, times) variance added along it since the time before
    own : (draws, times, n) variance added to each coordinate alone
    warmer : (draws, n) what 10 K add to a state after the last test; zero where temperature does
        not count, else the states are those at the reference temperature
    mounting : (draws, n) standard deviation of remounting, of a test to come
    """

    hours: FloatArray
    states: FloatArray
    direction: FloatArray
    shared: FloatArray
    own: FloatArray
    warmer: FloatArray
    mounting: FloatArray

    @cached_property
    def coordinates(self) -> FloatArray:
        """(draws, times, n) the loops' unconstrained coordinates, then followed amplitudes."""
        return to_loop(self.states)


@dataclass(frozen=True)
class LinearisedTrend:
    """A trend before its loops are sampled: by Gaussians that stand for them.

    Attributes
    ----------
    tests : in order of service hours
    prior, wear_prior : of the loops and of the wear
    clock : from service hours to the hours by which wear counts
    mode : where the loops were linearised
    draws : of the hyperparameters by the Gaussian step, as standard normal deviates
    followed : effects whose amplitudes are part of the state
    """

    tests: tuple[LoopEvidence, ...]
    prior: Prior
    wear_prior: WearPrior
    clock: ServiceClock
    mode: JointMode
    draws: HyperparameterDraws
    followed: FollowedEffects | None


@dataclass(frozen=True)
class Trend(LinearisedTrend):
    """A fitted trend.

    Attributes
    ----------
    met : draws of the hyperparameters and of what every test met, by the loops themselves
    warnings : in words
    """

    met: Met
    warnings: tuple[str, ...]

    @staticmethod
    def of(linearised: LinearisedTrend, met: Met, warnings: tuple[str, ...]) -> Trend:
        """From the trend before its loops were sampled."""
        return Trend(**vars(linearised), met=met, warnings=warnings)

    @property
    def _state_prior(self) -> StatePrior:
        return StatePrior.of(self.prior, self.wear_prior)

    @property
    def now_hours(self) -> float:
        """Service hours of the last test."""
        return self.tests[-1].service_hours

    @property
    def converged(self) -> bool:
        """Whether the samplings and the linearisation came to rest."""
        linearised = self.mode.converged or self.met.sampled
        return self.draws.converged and linearised and self.met.converged

    @property
    def _rate_ahead(self) -> RateAhead:
        """How the pace of wear changes from now on; as so far where no two tests have shown one.

        That it rises past the last test was found of drives whose pace was seen. Of a drive that
        was not, the clock's own prior holds what is expected of a whole life.
        """
        hours = {test.service_hours for test in since_replaced(self.tests)}
        return self.wear_prior.rate_ahead if len(hours) > 1 else _LEVEL

    def paths(self, hours: FloatArray, rng: np.random.Generator, draws: int) -> FloatArray:
        """Coordinates (draws, times, n) of paths of the drive's state; see `wandering_paths`."""
        return self.wandering_paths(hours, rng, draws).coordinates

    def wandering_paths(
        self,
        hours: FloatArray,
        rng: np.random.Generator,
        draws: int,
        load_factor: float = 1.0,
        *,
        wear_ends: bool = True,
    ) -> Paths:
        """Paths of the drive's state, without the scatter of remounting.

        Parameters
        ----------
        hours : (times,) service hours, rising, before and after now
        rng : source of randomness
        draws : number of paths
        load_factor : pace of the clock past the last test over the pace so far, e.g. 0.8³ at
            80 % torque
        wear_ends : whether it does as the wear prior has it; without, the same random numbers give
            the same paths but for that
        """
        met = self.met.thinned(draws, rng)
        values = Hyperparameters.of(met.deviates, self.wear_prior)
        clock = self.clock.slowed(load_factor)
        timeline, which = Timeline.of(self.tests, clock, self.wear_prior, hours)
        steps = Steps.of(timeline, values, self._state_prior, self.wear_prior)
        behind = int(np.flatnonzero(which >= 0)[-1]) + 1
        course = self.given(values).draw_behind(
            met.measured, steps.upto(behind), which[:behind], rng
        )
        states = within_reach(steps, course.states)
        now = at_reference(steps, states[:, -1], course.carried, behind - 1)
        start = (now, course.carried)
        ahead = simulate_ahead(steps, rng, start, behind, self._rate_ahead)
        ends = self.wear_prior.worn_out if wear_ends else {}
        ahead, left = worn_ahead(steps, now, ahead, ends, rng)
        left = np.concatenate([np.ones_like(states), left], axis=1)[:, which < 0]
        return Paths(
            np.asarray(hours, dtype=float),
            np.concatenate([states, ahead], axis=1)[:, which < 0],
            self.wear_prior.loading_mean * left,
            steps.shared[:, which < 0],
            steps.own[:, which < 0] * left**2,
            per_step_of_warmth(steps, course.carried),
            values.scatter[:, None] * self.wear_prior.scales,
        )

    def measured(self, rng: np.random.Generator, draws: int) -> FloatArray:
        """Draw what each test met, scatter and warmth included, given all: (draws, tests, n)."""
        return to_loop(self.met.thinned(draws, rng).measured)

    def deviates(self, rng: np.random.Generator, draws: int) -> tuple[FloatArray, FloatArray]:
        """Draw deviates of the wear prior's file: hyperparameters (draws, k), loadings (draws, 8).

        Both of one draw belong together.
        """
        prior, met = self.wear_prior, self.met.thinned(draws, rng)
        given = self.given(Hyperparameters.of(met.deviates, prior))
        every = np.arange(len(self.tests))
        course = given.draw_behind(met.measured, given.steps, every, rng)
        departure = course.loadings - prior.loading_mean
        return prior.deviates(met.deviates), (departure / prior.loading_sd)[:, : len(NAMES)]

    @property
    def breaks(self) -> bool:
        """Whether the state steps before a test, by an event or by what came at once."""
        return bool(self.wear_prior.sudden) or any(test.event for test in self.tests[1:])

    def hyperparameters(self) -> Mapping[str, FloatArray]:
        """Draws of the hyperparameters by name, (draws,) each."""
        named = Hyperparameters.of(self.met.deviates, self.wear_prior).named()
        return {name: named[name] for name in self._in_use}

    def carried_by_prior(self) -> tuple[str, ...]:
        """Hyperparameters whose spread the tests hardly narrowed: by less than a fifth.

        With a fleet, less than that of what the fleet says of its drives.
        """
        prior, standard = self.wear_prior, np.random.default_rng(0).standard_normal
        before = _spread(prior.deviates(standard((_PRIOR_DRAWS, len(HYPERPARAMETERS)))))
        narrowed = _spread(prior.deviates(self.met.deviates)) < 0.8 * before
        wide = dict(zip(HYPERPARAMETERS, ~narrowed, strict=True))
        return tuple(name for name in self._in_use if wide[name])

    @property
    def _in_use(self) -> tuple[str, ...]:
        by_load = self.clock.by_load
        return tuple(name for name in HYPERPARAMETERS if by_load or name != LOAD_SHARE)

    def given(self, values: Hyperparameters) -> GivenMeasured:
        """The trend along its tests under hyperparameters, given what the tests met."""
        timeline, _ = Timeline.of(self.tests, self.clock, self.wear_prior)
        steps = Steps.of(timeline, values, self._state_prior, self.wear_prior)
        seen = SeenTests.of(self.mode.loops, self.tests, self.wear_prior)
        return GivenMeasured.of(steps, values.scatter, seen.scales, seen.unknown_part)


def _spread(deviates: FloatArray) -> FloatArray:
    """Standard deviation (k,) of deviates (draws, k); a steady pace has none of its rate's."""
    return np.asarray(np.ma.masked_invalid(deviates).std(axis=0).filled(0.0))
