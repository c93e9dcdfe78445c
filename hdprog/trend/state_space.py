"""The trend as a linear state-space model, given its few hyperparameters.

    x(t) = x_0 + ∫L dw + m·(r·(1 − exp(−u/ρ)) + ∫v du) + d(t)     state, n numbers
    x_j  = x(t_j) + e_j                                            what test j meets

The state is the 8 wear coordinates and the amplitudes of lasting effects that are followed.
x_0 has the loop's prior, once a drive; the loadings L a Gaussian around the direction of wear m.
Running-in leaves r, a Gaussian, within the first hours; without it, it would pass for a clock that
slows down. The rate of wear departs from the clock's by v, a random walk from zero over the
logarithm of the expected wear u (a local linear trend), and so does every loading from where it
began: what wears at different places need not keep step. d is a random walk over the expected
wear (a Wiener process with a time-scale transformation), along m and of every coordinate alone.
e_j is the scatter of remounting. Events, and effects that came at once, leave steps in x that last
(see `hdprog.trend.sudden_steps`). Where tests differ in temperature, x stands for x(t) + β·δ(t),
the state as warm as the drive was (see `hdprog.trend.temperature`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.temperature import Temperatures, Warming
from hdprog.trend.wear_clock import ServiceClock, WearClock
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import MESH, WearPrior

LOAD_SHARE = "load_share"
HYPERPARAMETERS: tuple[str, ...] = (
    "wear_rate",
    "clock_exponent",
    "clock_curvature",
    "running_in_length",
    "volatility",
    "rate_volatility",
    "own_volatility",
    "preload_volatility",
    "remounting_scatter",
    LOAD_SHARE,
)
"""Sampled as standard normal deviates, one column each."""
BY_DRAW = ("wear", "settled", "passed", "lived", "departure", "shared", "own", "loading_walk")
"""Fields of `Steps` with a row for each draw and a column for each time."""
_SETTLING = 0.02  # units of wear before which the rate is not spoken of


@dataclass(frozen=True)
class Hyperparameters:
    """Values of the hyperparameters, each (draws,); see priors/trend.toml.

    Under each the loadings have the mean `loading_mean`, (draws, n) or (1, n) where it is the
    same for all, and the standard deviation `loading_sd`, (draws, n) or (n,).
    """

    clock: WearClock
    running_in_length: FloatArray
    volatility: FloatArray
    rate_volatility: FloatArray
    own_volatility: FloatArray
    preload_volatility: FloatArray
    scatter: FloatArray
    load_share: FloatArray
    loading_mean: FloatArray
    loading_sd: FloatArray

    @staticmethod
    def of(deviates: FloatArray, prior: WearPrior) -> Hyperparameters:
        """From standard normal deviates (draws, 10)."""
        known = prior.deviates(deviates)
        loadings, loading_sd = prior.loadings_given(known)
        rate, exponent, curvature, length, common, change, own, preload, scatter, load = known.T
        return Hyperparameters(
            WearClock(
                prior.wear_rate.at(rate),
                prior.clock_exponent.at(exponent),
                prior.clock_curvature.at(curvature),
                prior.wear_rate.reference_hours,
            ),
            prior.running_in_length.at(length),
            prior.volatility.at(common),
            prior.rate_volatility.at(change),
            prior.own_volatility.at(own),
            prior.preload_volatility.at(preload),
            prior.remounting_scatter.at(scatter),
            prior.load_share.at(load),
            loadings,
            loading_sd,
        )

    def named(self) -> dict[str, FloatArray]:
        """(draws,) by the names of `HYPERPARAMETERS`."""
        clock = self.clock
        values = (
            clock.rate,
            clock.exponent,
            clock.curvature,
            self.running_in_length,
            self.volatility,
            self.rate_volatility,
            self.own_volatility,
            self.preload_volatility,
            self.scatter,
            self.load_share,
        )
        return dict(zip(HYPERPARAMETERS, values, strict=True))

    def own_drift(self, scales: FloatArray) -> FloatArray:
        """Spread (draws, n) of each coordinate's own drift per square root of a unit of wear.

        Parameters
        ----------
        scales : (n,) its relative size by coordinate
        """
        at_mesh = np.isin(np.arange(scales.size), MESH)
        volatility = np.where(
            at_mesh, self.preload_volatility[:, None], self.own_volatility[:, None]
        )
        return np.asarray(volatility * scales)


@dataclass(frozen=True)
class Timeline:
    """When the drive was looked at, and what was done to it.

    Attributes
    ----------
    age : (times,) service hours since the drive was new or replaced
    begins : (times,) True where a new drive begins: at the first time and at each replacement
    event_variance : (times, n) variance of the lasting step just before the time
    age_by_load : (times,) the same hours counted by load; None where no load is told
    temperatures : along the times; None where temperature does not count
    """

    age: FloatArray
    begins: NDArray[np.bool_]
    event_variance: FloatArray
    age_by_load: FloatArray | None = None
    temperatures: Temperatures | None = None

    @staticmethod
    def of(
        tests: Sequence[LoopEvidence],
        clock: ServiceClock,
        prior: WearPrior,
        hours: FloatArray | None = None,
    ) -> tuple[Timeline, NDArray[np.intp]]:
        """Timeline of tests in order and of further service hours among or after them.

        Returns
        -------
        the timeline, and (times,) which test each time is, −1 for a further time; at equal hours
        tests go first
        """
        extra = np.empty(0) if hours is None else np.asarray(hours, dtype=float)
        service = np.concatenate([[test.service_hours for test in tests], extra])
        which = np.concatenate([np.arange(len(tests)), np.full(extra.size, -1)])
        order = np.argsort(service, kind="stable")
        service, which = service[order], which[order].astype(np.intp)
        variance = np.zeros((service.size, prior.loading_mean.size))
        replaced = np.zeros(service.size, dtype=bool)
        for place, test in enumerate(which):
            if test >= 0:
                variance[place] = prior.step_variance(int(test), tests[test].event)
                replaced[place] = tests[test].event == "replaced"
        begins = replaced.copy()
        begins[0] = True
        first = np.maximum.accumulate(np.where(begins, np.arange(service.size), 0))

        def since_new(hours: FloatArray) -> FloatArray:
            return np.asarray(hours - np.where(replaced[first], hours[first], 0.0))

        by_load = since_new(clock(service)) if clock.counts_load else None
        found = Temperatures.of(tests)
        along = None if found is None else found.along(which)
        return Timeline(since_new(service), begins, variance, by_load, along), which

    def counted(self, load_share: FloatArray) -> FloatArray:
        """Hours by which wear counts, (draws, times), for shares of load (draws,)."""
        by_load = self.age if self.age_by_load is None else self.age_by_load
        share = load_share[:, None]
        return np.asarray((1 - share) * self.age + share * by_load)


@dataclass(frozen=True)
class Steps:
    """What happens from one time to the next, for every draw of the hyperparameters.

    Attributes
    ----------
    initial_mean, initial_variance : (n,) of x_0
    loading_mean : (draws, n) of L, or (1, n) where it is the same for all
    loading_variance : (draws, n) of L, or (n,) where it is the same for all
    direction : (n,) m of shared random wear, the expected loadings
    running_in : mean and variance of r
    begins : (times,) where x, L and r start anew
    wear : (draws, times) increment of wear
    settled : (draws, times) increment of the share of running-in that is done
    passed : (draws, times) increment of the walks' time
    lived : (draws, times) increment of the logarithm of expected wear, the time of v
    departure : (draws, times) variance that the rate's departure v gains meanwhile
    shared : (draws, times) variance added along the direction of wear
    own : (draws, times, n) variance added to each coordinate
    loading_walk : (draws, times, n) variance that each loading gains meanwhile
    warming : what temperature does; None where it does not count
    """

    initial_mean: FloatArray
    initial_variance: FloatArray
    loading_mean: FloatArray
    loading_variance: FloatArray
    direction: FloatArray
    running_in: tuple[float, float]
    begins: NDArray[np.bool_]
    wear: FloatArray
    settled: FloatArray
    passed: FloatArray
    lived: FloatArray
    departure: FloatArray
    shared: FloatArray
    own: FloatArray
    loading_walk: FloatArray
    warming: Warming | None = None

    @property
    def size(self) -> int:
        """How many numbers a state has."""
        return self.initial_mean.size

    @property
    def carried(self) -> int:
        """How many numbers a state carries along: L, β where there is one, r and v."""
        return self.size * (1 if self.warming is None else 2) + 2

    @staticmethod
    def of(
        timeline: Timeline, values: Hyperparameters, prior: StatePrior, wear_prior: WearPrior
    ) -> Steps:
        """Lay the steps along a timeline."""
        expected = values.clock.expected(timeline.counted(values.load_share))
        reached = values.clock.level(expected)
        worn = _increments(reached, timeline.begins)
        # What has levelled off still wanders; what accelerates wanders the more.
        counted = np.maximum(worn, _increments(expected, timeline.begins))
        # The rate changes by the share of life gone by, so that no unit of wear is special to it.
        logarithm = np.log1p(np.maximum(expected, reached) / _SETTLING)
        lived = _increments(logarithm, timeline.begins)
        settled = -np.expm1(-expected / values.running_in_length[:, None])
        alone = values.own_drift(wear_prior.drift_scales)
        own = alone[:, None] ** 2 * counted[..., None]
        # A steady pace is that of every coordinate.
        turning = np.where(values.rate_volatility[:, None] > 0.0, alone, 0.0)
        own_pace = (wear_prior.own_pace.spread * turning[:, None]) ** 2 * lived[..., None]
        found = timeline.temperatures
        warming = None if found is None else Warming.of(found, timeline.begins, wear_prior)
        return Steps(
            prior.mean,
            prior.sd**2,
            values.loading_mean,
            values.loading_sd**2,
            wear_prior.loading_mean,
            (wear_prior.running_in.mean, wear_prior.running_in.sd**2),
            timeline.begins,
            worn,
            _increments(settled, timeline.begins),
            counted,
            lived,
            values.rate_volatility[:, None] ** 2 * lived,
            values.volatility[:, None] ** 2 * counted,
            own + timeline.event_variance,
            own_pace,
            warming,
        )

    def rows(self, chosen: NDArray[np.intp]) -> Steps:
        """Keep some of the draws, in any order and as often as they are asked for."""
        kept = {name: getattr(self, name)[chosen] for name in BY_DRAW}
        mean, variance = self.loading_mean, self.loading_variance
        kept["loading_mean"] = mean if len(mean) == 1 else mean[chosen]
        kept["loading_variance"] = variance if variance.ndim == 1 else variance[chosen]
        return replace(self, **kept)

    def upto(self, times: int) -> Steps:
        """Keep the first few times only."""
        kept = {name: getattr(self, name)[:, :times] for name in BY_DRAW}
        warming = None if self.warming is None else self.warming.upto(times)
        return replace(self, begins=self.begins[:times], warming=warming, **kept)


def steps_of(
    deviates: FloatArray, timeline: Timeline, state_prior: StatePrior, wear_prior: WearPrior
) -> tuple[Steps, FloatArray]:
    """Steps along a timeline, and scatter (draws,), of hyperparameters' deviates (draws, k)."""
    values = Hyperparameters.of(deviates, wear_prior)
    return Steps.of(timeline, values, state_prior, wear_prior), values.scatter


def _increments(values: FloatArray, begins: NDArray[np.bool_]) -> FloatArray:
    """Increments along the last axis of a course that starts from zero at each beginning."""
    before = np.where(begins, 0.0, np.roll(values, 1, axis=-1))
    return np.asarray(np.maximum(values - before, 0.0))
