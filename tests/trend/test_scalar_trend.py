"""The trend of one figure, as the fleets' benchmark runs it, is that of the whole drive."""

import numpy as np
import pytest

from hdprog.forecast.crossing import first_crossing, forecast_hours
from hdprog.forecast.limits import Margins
from hdprog.physics.parameters import NAMES
from hdprog.trend.fleet import FleetPrior
from hdprog.trend.gaussian_step import GaussianStep
from hdprog.trend.joint_refit import QUICK, begin_meeting
from hdprog.trend.kalman_filter import log_evidence
from hdprog.trend.observation import Observations
from hdprog.trend.relinearise import JointMode
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.trend import Trend
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior, linearise
from tests.benchmarks.degradation.series import (
    AT,
    Reading,
    Series,
    Study,
    readings,
    state_prior,
    wear_prior,
)
from tests.benchmarks.prognostics.scalar_trend import density, fit_scalar_trend

STUDY = Study("test", "", "", "", "", 0.0, 1.0, 1000.0, 5)
DEVIATES = len(HYPERPARAMETERS) + len(NAMES)


@pytest.fixture
def unit() -> list[Reading]:
    hours = np.array([1.0, 100.0, 200.0, 300.0, 400.0])
    values = np.array([0.0, 0.11, 0.19, 0.31, 0.40])
    return readings(Series("unit", hours, values), 5, state_prior())


def some_fleet() -> FleetPrior:
    root = 0.3 * np.random.default_rng(5).standard_normal((DEVIATES, DEVIATES))
    return FleetPrior(("a",), 0.1 * root[0], root @ root.T + 0.1 * np.eye(DEVIATES))


@pytest.mark.parametrize("fleet", [None, some_fleet()], ids=["shipped", "fleet"])
def test_evidence_is_that_of_all_eight_coordinates(unit, fleet):
    wear = wear_prior(STUDY)
    wear = wear if fleet is None else wear.learnt_from(fleet)
    deviates = np.random.default_rng(1).standard_normal((40, len(HYPERPARAMETERS)))
    values = Hyperparameters.of(deviates, wear)
    timeline, _ = Timeline.of(unit, ServiceClock.of(unit), wear)
    steps = Steps.of(timeline, values, StatePrior.of(state_prior(), wear), wear)
    loops = [linearise(one, np.zeros(len(NAMES))) for one in unit]
    whole = log_evidence(steps, values.scatter, Observations.of(loops, wear.scales))
    alone = density(unit, wear)(deviates) + 0.5 * np.sum(deviates**2, axis=1)
    inside = np.isfinite(alone)  # not so much wear that the fit refuses it
    assert inside.sum() > 20
    np.testing.assert_allclose(alone[inside], whole[inside], atol=1e-6, rtol=1e-9)


def test_crossing_is_that_of_the_whole_trend(unit):
    # False alarm: two samples of 4000 paths differ by 0.05 once in ten thousand seeds.
    wear, prior, draws = wear_prior(STUDY), state_prior(), 4000
    alone = fit_scalar_trend(unit, wear, np.random.default_rng(2))
    hours = forecast_hours(400.0, 4000.0)
    points = np.tile(prior.mean, (len(unit), 1))
    loops = tuple(linearise(one, point) for one, point in zip(unit, points, strict=True))
    mode = JointMode(points, loops, converged=True, steps=0)
    clock, spread = ServiceClock.of(unit), StatePrior.of(prior, wear)
    timeline, _ = Timeline.of(unit, clock, wear)
    step = GaussianStep.of(unit, mode, timeline, spread, wear, 0.5, prior.softplus_scale)
    met = begin_meeting(step, alone.draws, np.random.default_rng(5), QUICK)()
    trend = Trend(tuple(unit), prior, wear, clock, mode, alone.draws, None, met, ())
    paths = trend.wandering_paths(hours, np.random.default_rng(3), draws)
    wander = paths.shared * paths.direction[..., AT] ** 2 + paths.own[..., AT]
    limits = [Margins(1.0 - paths.states[..., AT], wander)]
    whole = first_crossing(hours, limits, survived_so_far=True)
    found = alone.crossing(hours, np.random.default_rng(4), draws)
    assert np.max(np.abs(found.probability - whole.probability)) < 0.05
