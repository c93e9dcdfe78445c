"""hdprog's trend of a single figure, and the forecast of its first crossing.

`fit_trend` follows eight coordinates of a drive. Readings of one figure inform one of them (see
`tests.benchmarks.degradation.series`); given the hyperparameters the other seven neither say nor
learn anything, so leaving them out changes nothing but the time that a fit takes. Clock, state
space, filter, sampler, pooling and first crossing are hdprog's own; that evidence and crossing are
those of the whole trend is tested in tests/trend/test_scalar_trend.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hdprog.forecast.crossing import Crossing, first_crossing
from hdprog.forecast.limits import Margins
from hdprog.inference.information import Linearised
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.ahead import simulate_ahead
from hdprog.trend.hyperparameters import HyperparameterDraws, LogDensity
from hdprog.trend.kalman_filter import log_evidence
from hdprog.trend.observation import Observations
from hdprog.trend.smoother import draw
from hdprog.trend.state_space import Hyperparameters, Steps, Timeline
from hdprog.trend.steady_evidence import said_by, sampled, steady_said
from hdprog.trend.steady_pace import Told
from hdprog.trend.trend_density import FARTHEST_DEVIATE, MOST_WEAR, UNWORN
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import RateAhead, WearPrior
from tests.benchmarks.degradation.series import AT, Reading


def of_one_figure(steps: Steps) -> Steps:
    """The steps of the coordinate that readings inform, the others left out."""
    return replace(
        steps,
        initial_mean=steps.initial_mean[[AT]],
        initial_variance=steps.initial_variance[[AT]],
        loading_mean=steps.loading_mean[:, [AT]],
        loading_variance=steps.loading_variance[..., [AT]],
        direction=steps.direction[[AT]],
        own=steps.own[..., [AT]],
        loading_walk=steps.loading_walk[..., [AT]],
    )


def information(readings: Sequence[Reading]) -> tuple[Linearised, ...]:
    """What each reading says of its one coordinate."""
    found = []
    for reading in readings:
        whole = reading.linearise(np.zeros(len(NAMES)))
        found.append(
            Linearised(
                whole.precision[np.ix_([AT], [AT])],
                whole.information[[AT]],
                whole.log_likelihood,
            )
        )
    return tuple(found)


@dataclass(frozen=True)
class ScalarTrend:
    """The trend of one figure; see `hdprog.trend.trend.Trend`.

    Attributes
    ----------
    readings : in order of service hours
    wear_prior : as fitted with
    draws : of the hyperparameters
    """

    readings: tuple[Reading, ...]
    wear_prior: WearPrior
    draws: HyperparameterDraws

    def crossing(
        self,
        hours: FloatArray,
        rng: np.random.Generator,
        draws: int,
        ahead: RateAhead | None = None,
    ) -> Crossing:
        """First crossing of one, the whole way to failure.

        Parameters
        ----------
        hours : (times,) service hours, that of the last reading first
        rng : source of randomness
        draws : number of paths
        ahead : how the pace changes past the last reading; that of the wear prior if left out
        """
        values = Hyperparameters.of(self.draws.thinned(draws, rng), self.wear_prior)
        steps, which = _steps(self.readings, self.wear_prior, values, hours)
        behind = len(self.readings)
        course = draw(
            steps.upto(behind), _observations(self.readings, self.wear_prior), values.scatter, rng
        )
        rate_ahead = self.wear_prior.rate_ahead if ahead is None else ahead
        start = (course.states[:, -1], course.carried)
        found = simulate_ahead(steps, rng, start, behind, rate_ahead)
        margin = 1.0 - found[..., 0]
        wander = steps.shared * steps.direction[0] ** 2 + steps.own[..., 0]
        limits = [Margins(margin, wander[:, which < 0])]
        return first_crossing(hours, limits, survived_so_far=True)

    def told(self, rng: np.random.Generator) -> Told:
        """What the readings say, the prior left out; see `what_tests_say`."""
        shipped, readings = self.wear_prior, self.readings
        steady = steady_said(
            shipped, lambda prior: density(readings, prior), self._loadings, self.draws, UNWORN, rng
        )
        return Told(said_by(self.draws, shipped, self._loadings, rng), steady)

    def _loadings(
        self, deviates: FloatArray, prior: WearPrior, rng: np.random.Generator
    ) -> FloatArray:
        """Deviates of the loadings (draws, 8), those of the other figures as the prior has them."""
        values = Hyperparameters.of(deviates, prior)
        steps, _ = _steps(self.readings, prior, values)
        course = draw(steps, _observations(self.readings, prior), values.scatter, rng)
        loadings = rng.standard_normal((len(deviates), len(NAMES)))
        mean, sd = prior.loading_mean[AT], prior.loading_sd[AT]
        loadings[:, AT] = (course.loadings[:, 0] - mean) / sd
        return loadings


def _steps(
    readings: Sequence[Reading],
    wear_prior: WearPrior,
    values: Hyperparameters,
    hours: FloatArray | None = None,
) -> tuple[Steps, np.ndarray]:
    timeline, which = Timeline.of(readings, ServiceClock.of(readings), wear_prior, hours)
    whole = Steps.of(timeline, values, StatePrior.of(readings[0].prior, wear_prior), wear_prior)
    return of_one_figure(whole), which


def _observations(readings: Sequence[Reading], wear_prior: WearPrior) -> Observations:
    return Observations.of(information(readings), wear_prior.scales[[AT]])


def density(readings: Sequence[Reading], wear_prior: WearPrior) -> LogDensity:
    """Log posterior density of the hyperparameters' deviates, states integrated out."""
    seen = _observations(readings, wear_prior)

    def log_density(deviates: FloatArray) -> FloatArray:
        inside = np.abs(deviates).max(axis=1) < FARTHEST_DEVIATE
        safe = np.where(inside[:, None], deviates, UNWORN)
        values = Hyperparameters.of(safe, wear_prior)
        steps, _ = _steps(readings, wear_prior, values)
        inside &= steps.passed.sum(axis=1) < MOST_WEAR
        with np.errstate(all="ignore"):
            evidence = log_evidence(steps, values.scatter, seen)
        inside &= np.isfinite(evidence)
        return np.where(inside, evidence - 0.5 * np.sum(deviates**2, axis=1), -np.inf)

    return log_density


def fit_scalar_trend(
    readings: Sequence[Reading], wear_prior: WearPrior, rng: np.random.Generator
) -> ScalarTrend:
    """Fit the trend to the readings of one unit."""
    log_density = density(readings, wear_prior)
    draws = sampled(log_density, UNWORN.size, rng, UNWORN)
    return ScalarTrend(tuple(readings), wear_prior, draws)


def fleet_prior(
    wear_prior: WearPrior, fits: Sequence[ScalarTrend], rng: np.random.Generator
) -> WearPrior:
    """The wear prior for a unit whose fleet has been fitted."""
    told = [fit.told(rng) for fit in fits]
    return wear_prior.taught_by([str(at) for at in range(len(told))], told)
