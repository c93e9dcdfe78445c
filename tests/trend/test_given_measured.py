"""The trend given what every test met equals the dense Gaussian of all tests."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.trend.given_measured import GivenMeasured
from hdprog.trend.relinearise import JointPrior
from hdprog.trend.smoother import simulate
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import read_wear_prior
from tests.trend.stand_in import PRIOR

WEAR_PRIOR = read_wear_prior()
STATE_PRIOR = StatePrior.of(PRIOR, WEAR_PRIOR)
HOURS = np.array([0.0, 400.0, 900.0, 1000.0, 2500.0])
BEGINS = np.array([True, False, False, True, False])  # replaced before the fourth


def trend_at(deviates: np.ndarray) -> tuple[Steps, np.ndarray]:
    age = np.where(np.cumsum(BEGINS) == 1, HOURS, HOURS - HOURS[3])
    timeline = Timeline(age, BEGINS, np.zeros((HOURS.size, 8)))
    values = Hyperparameters.of(deviates, WEAR_PRIOR)
    return Steps.of(timeline, values, STATE_PRIOR, WEAR_PRIOR), values.scatter


def given(deviates: np.ndarray) -> GivenMeasured:
    steps, scatter = trend_at(deviates)
    return GivenMeasured.of(steps, scatter, WEAR_PRIOR.scales, None)


def drawn(steps: Steps, rng: np.random.Generator) -> np.ndarray:
    return simulate(steps, rng).states


def test_squares_are_those_of_the_dense_gaussian() -> None:
    rng = np.random.default_rng(1)
    deviates = 0.5 * rng.standard_normal((3, len(HYPERPARAMETERS)))
    steps, scatter = trend_at(deviates)
    courses = np.stack([drawn(steps, rng) for _ in range(2)])
    found = given(deviates).predictor.squares(courses)
    for draw in range(3):
        dense = JointPrior.of(steps.rows(np.array([draw])), float(scatter[draw]), WEAR_PRIOR.scales)
        expected = [-2 * dense.log_density(course[draw]) for course in courses]
        assert found[:, draw] == pytest.approx(expected, rel=1e-6)


def test_states_behind_have_the_mean_and_spread_of_the_dense_gaussian() -> None:
    """Of 6 000 draws a mean errs by 0.013 spreads: 40 of them by 0.06 once in 10 000 seeds."""
    rng = np.random.default_rng(2)
    fixed, count = np.zeros((1, len(HYPERPARAMETERS))), 6000
    steps, scatter = trend_at(fixed)
    dense = JointPrior.of(steps, float(scatter[0]), WEAR_PRIOR.scales)
    measured = drawn(steps, rng)[0]
    noise = np.diag(np.tile((scatter[0] * WEAR_PRIOR.scales) ** 2, HOURS.size))
    whole = np.linalg.inv(dense.precision)
    gain = (whole - noise) @ dense.precision
    off = (measured - dense.mean).ravel()
    mean = dense.mean.ravel() + gain @ off
    spread = np.sqrt(np.diag((whole - noise) - gain @ (whole - noise)))

    many = np.repeat(fixed, count, axis=0)
    steps, _ = trend_at(many)
    repeated = np.broadcast_to(measured, (count, *measured.shape))
    which = np.arange(HOURS.size)
    course = given(many).draw_behind(repeated, steps, which, rng)
    flat = course.states.reshape(count, -1)
    assert np.abs((flat.mean(axis=0) - mean) / spread).max() < 0.06
    assert flat.std(axis=0) / spread == pytest.approx(1.0, abs=0.05)
    assert course.carried.shape == (count, steps.carried)
