"""Forecasts of limits from a fitted trend."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.forecast.crossing import forecast
from hdprog.forecast.limits import margins
from hdprog.physics.figures import Operation
from hdprog.results import LEVELS
from hdprog.trend.fitting import fit_trend
from hdprog.trend.joint_gaussian import joint_gaussian
from hdprog.trend.state_space import Hyperparameters
from hdprog.trend.trend import Trend
from hdprog.trend.wear_prior import read_wear_prior
from tests.hasty import HASTY
from tests.trend.stand_in import ALPHA, PRIOR, wearing_drive

OPERATION = Operation(ALPHA, 63.0, 63.0)
SECANT = Limit("secant_stiffness_Nm_per_rad", 12_000.0, "below", 14.0)
LOST = Limit("lost_motion_arcmin", 2.5, "above")
HOURS = np.linspace(0.0, 3000.0, 5)


@pytest.fixture(scope="module")
def trend() -> Trend:
    rng = np.random.default_rng(1)
    tests = wearing_drive(rng, (HOURS / 4000.0) ** 0.9, HOURS)
    return fit_trend(tests, PRIOR, read_wear_prior(), rng, quick=True, joint_effort=HASTY)


def run(trend: Trend, *limits: Limit, **settings: float) -> tuple:
    drive = Drive(rated_torque=63.0, limits=limits, forecast=ForecastSettings(**settings))
    return forecast(trend, drive, OPERATION, np.random.default_rng(2))


def test_contract_of_a_forecast(trend: Trend) -> None:
    found = run(trend, SECANT, LOST, horizon_hours=20_000.0, next_shutdown_hours=4000.0)
    assert [each.limit for each in found] == [SECANT, LOST, None]
    for each in found:
        hours, probability = each.crossing_probability.T
        assert (hours[0], hours[-1]) == (3000.0, 20_000.0)
        assert np.all(np.diff(probability) >= 0)
        assert probability[0] == 0.0
        assert not each.already_crossed
        quantiles = [each.remaining_hours[level] for level in LEVELS]
        known = [value for value in quantiles if value is not None]
        assert known == sorted(known)
        assert each.inspect_before_hours == pytest.approx(3000.0 + quantiles[0])
        at = np.interp(4000.0, hours, probability)
        assert each.probability_crossed_by_shutdown == pytest.approx(at)
        # The true course passes both limits 1 000 hours from now, as wear reaches one.
        assert 200.0 < each.remaining_hours[0.5] < 3000.0
    first, each = found[2].crossing_probability[:, 1], found[:2]
    assert np.all(first >= np.max([one.crossing_probability[:, 1] for one in each], axis=0) - 1e-9)
    assert len(run(trend, SECANT)) == 1
    assert run(trend) == ()


def test_a_limit_behind_us_is_said_to_be_crossed(trend: Trend) -> None:
    (found,) = run(trend, dataclasses.replace(SECANT, threshold=25_000.0))
    assert found.already_crossed
    assert found.inspect_before_hours == 3000.0
    assert found.remaining_hours[0.5] == 0.0
    assert found.probability_crossed_by_horizon == pytest.approx(1.0, abs=1e-6)


def test_a_limit_out_of_reach_has_no_hours(trend: Trend) -> None:
    (found,) = run(trend, dataclasses.replace(SECANT, threshold=100.0), horizon_hours=4000.0)
    assert found.inspect_before_hours is None
    assert set(found.remaining_hours.values()) == {None}
    assert found.probability_crossed_by_horizon == pytest.approx(0.0, abs=1e-6)


def test_less_load_gives_longer_life(trend: Trend) -> None:
    drive = Drive(limits=(SECANT,), forecast=ForecastSettings(40_000.0))
    full, light = (
        forecast(trend, drive, OPERATION, np.random.default_rng(3), load_factor=factor)[0]
        for factor in (1.0, 0.8**3)
    )
    assert light.remaining_hours[0.5] > 1.5 * full.remaining_hours[0.5]


def test_the_grid_hardly_matters(trend: Trend) -> None:
    """P(crossed) at one hour from paths on a coarse and a fine grid; Monte-Carlo error apart."""
    found = []
    for times in (8, 60):
        hours = np.linspace(3000.0, 4200.0, times)
        paths = trend.wandering_paths(hours, np.random.default_rng(4), 2000)
        from hdprog.forecast.crossing import first_crossing

        crossing = first_crossing(hours, [margins(SECANT, paths, PRIOR, OPERATION)])
        found.append(crossing.probability[-1])
    assert found[0] == pytest.approx(found[1], abs=4 * np.sqrt(0.5 / 2000))


def test_a_test_to_come_is_mounted_as_those_were_that_were_seen(trend: Trend) -> None:
    """What remounting adds to the variances of what the tests met, coordinate by coordinate."""
    paths = trend.wandering_paths(HOURS[-1:] + 500.0, np.random.default_rng(5), 20)
    met = trend.met.thinned(20, np.random.default_rng(5))
    values = Hyperparameters.of(met.deviates, trend.wear_prior)
    steps, scales = trend.given(values).steps, trend.wear_prior.scales
    variances = [
        np.diagonal(joint_gaussian(steps, scatter, scales)[1], axis1=1, axis2=2)[:, -8:]
        for scatter in (values.scatter, 0.0 * values.scatter)
    ]
    np.testing.assert_allclose(paths.mounting**2, variances[0] - variances[1], rtol=1e-3)
    assert np.ptp(paths.mounting, axis=1).min() > 0  # the teeth's threshold scatters by more
