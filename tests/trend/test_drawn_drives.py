"""Drives drawn for the calibration of forecasts follow the process that the filter predicts."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from hdprog.trend.kalman_filter import Predicted
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior
from tests.benchmarks.end_to_end import drives


def test_states_drawn_step_by_step_have_the_mean_and_covariance_of_the_filter() -> None:
    wear = drives.wear_prior()
    hours = np.linspace(0.0, drives.NOW, drives.TESTS)
    tests = [
        SimpleNamespace(service_hours=h, event=None, load_hours=None, temperature_C=None)
        for h in hours
    ]
    timeline, _ = Timeline.of(tests, ServiceClock.of(tests), wear)
    deviates = np.full((1, len(HYPERPARAMETERS)), 0.4)
    values = Hyperparameters.of(deviates, wear)
    steps = Steps.of(timeline, values, StatePrior.of(drives.loop_prior(), wear), wear)
    predicted = Predicted.new(steps, 1)
    for time in range(drives.TESTS):
        predicted.advance(steps, np.outer(steps.direction, steps.direction), time)

    rng = np.random.default_rng(5)
    count = 6000
    last = np.array([drives.until_now(steps, rng)[0][-1] for _ in range(count)])
    spread = np.sqrt(np.diag(predicted.xx[0]))
    off = (last.mean(axis=0) - predicted.x[0]) / spread
    assert np.abs(off).max() < 4 / np.sqrt(count)
    correlation = (np.cov(last.T) - predicted.xx[0]) / np.outer(spread, spread)
    # The error of a covariance of unit variances is at most sqrt(2/count).
    assert np.abs(correlation).max() < 4 * np.sqrt(2 / count)


def test_the_same_number_is_the_same_drive() -> None:
    one, other = drives.draw(3), drives.draw(3)
    assert np.array_equal(one.loops[0].angle, other.loops[0].angle)
    assert one.crossings == other.crossings
    assert not np.array_equal(one.loops[0].angle, drives.draw(4).loops[0].angle)
