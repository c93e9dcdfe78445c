"""Gears of one shape wear alike at any size: torques and stiffnesses a tenth, angles the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import mean

import numpy as np
import pytest

from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.forecast.crossing import forecast
from hdprog.inference.priors import Prior
from hdprog.physics.figures import Operation
from hdprog.physics.parameters import NAMES
from hdprog.results import Forecast
from hdprog.trend.fitting import fit_trend
from hdprog.trend.wear_prior import read_wear_prior
from tests.trend.stand_in import ALPHA, PRIOR, SimulatedLoop, wearing_drive

HOURS = np.array([0.0, 500.0, 900.0])
SHIFT = np.where(np.isin(NAMES, ("K_F", "K_W", "b", "T_i")), np.log(0.1), 0.0)
TENTH = replace(PRIOR, mean=PRIOR.mean + SHIFT, softplus_scale=PRIOR.softplus_scale / 10)


def forecasts(
    tests: Sequence[SimulatedLoop], prior: Prior, size: float, seed: int
) -> tuple[Forecast, ...]:
    """Of a limit on the secant stiffness and of one on the width."""
    limits = (
        Limit("secant_stiffness_Nm_per_rad", 15_000.0 * size, "below", 14.0 * size),
        Limit("hysteresis_width_arcmin", 0.3, "below"),
    )
    drive = Drive(limits=limits, forecast=ForecastSettings(20_000.0))
    rng = np.random.default_rng([seed, 1])
    trend = fit_trend(tests, prior, read_wear_prior(), rng, quick=True)
    operation = Operation(ALPHA, 63.0 * size, 63.0 * size)
    return forecast(trend, drive, operation, np.random.default_rng([seed, 2]))


def test_a_gear_of_a_tenth_of_the_torque_has_as_long_to_live() -> None:
    """By seed a median differs by a twenty-fifth (standard deviation over twelve seeds).

    The mean of two then by a thirty-fifth, two such means by a twenty-fifth from each other: what
    is allowed is 3.5 standard deviations: by chance beyond it in about one run of a thousand.
    """
    whole = wearing_drive(np.random.default_rng(4), HOURS / 1500.0, HOURS)
    tenth = [
        replace(test, torque=test.torque / 10, prior=TENTH, start=test.start + SHIFT)
        for test in whole
    ]
    seeds = (1, 2)
    of_whole = zip(*(forecasts(whole, PRIOR, 1.0, seed) for seed in seeds), strict=True)
    of_tenth = zip(*(forecasts(tenth, TENTH, 0.1, seed) for seed in seeds), strict=True)
    for expected, found in zip(of_whole, of_tenth, strict=True):
        for level in (0.25, 0.5):
            hours = mean(one.remaining_hours[level] for one in expected)
            told = mean(one.remaining_hours[level] for one in found)
            assert told == pytest.approx(hours, rel=0.15)
        by_horizon = mean(one.probability_crossed_by_horizon for one in expected)
        told = mean(one.probability_crossed_by_horizon for one in found)
        assert told == pytest.approx(by_horizon, abs=0.03)
