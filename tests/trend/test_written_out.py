"""The Gaussian step written out equals that of the filter, and knows the numbers of its draws."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from hdprog.trend import written_out
from hdprog.trend.gaussian_step import GaussianStep, Tangents
from hdprog.trend.joint_gaussian import joint_gaussian
from hdprog.trend.relinearise import JointMode
from hdprog.trend.state_space import HYPERPARAMETERS, Timeline
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior, from_loop, linearise
from hdprog.trend.wear_prior import read_wear_prior
from hdprog.trend.written_out import WrittenOut
from tests.trend.stand_in import ALPHA, NEW, PRIOR, WEAR, wearing_drive

WEAR_PRIOR = read_wear_prior()
STATE_PRIOR = StatePrior.of(PRIOR, WEAR_PRIOR)
DRAWS = 6


@pytest.fixture(scope="module")
def step() -> GaussianStep:
    hours = np.array([0.0, 700.0, 1500.0])
    worn = np.array([0.3, 0.6, 0.9])
    tests = wearing_drive(np.random.default_rng(4), worn, hours)
    points = from_loop(NEW + worn[:, None] * WEAR)
    loops = tuple(linearise(test, point) for test, point in zip(tests, points, strict=True))
    timeline, _ = Timeline.of(tests, ServiceClock.of(tests), WEAR_PRIOR)
    mode = JointMode(points, loops, converged=True, steps=0)
    return GaussianStep.of(
        tests, mode, timeline, STATE_PRIOR, WEAR_PRIOR, ALPHA, PRIOR.softplus_scale
    )


@pytest.fixture(scope="module")
def deviates() -> np.ndarray:
    return 0.5 * np.random.default_rng(5).standard_normal((DRAWS, len(HYPERPARAMETERS)))


def drawn(at: WrittenOut, seed: int) -> tuple[np.ndarray, Tangents]:
    numbers = np.random.default_rng(seed).standard_normal((DRAWS, at.numbers))
    return numbers, at.tangents(numbers)


def test_draws_tell_the_numbers_that_they_were_made_from(
    step: GaussianStep, deviates: np.ndarray
) -> None:
    at = WrittenOut.of(step, deviates)
    numbers, tangents = drawn(at, 6)
    np.testing.assert_allclose(at.numbers_of(tangents), numbers, atol=1e-8)


def test_weights_are_those_of_the_filter(step: GaussianStep, deviates: np.ndarray) -> None:
    at = WrittenOut.of(step, deviates)
    _, tangents = drawn(at, 7)
    found, met = at.log_weight(tangents)
    wanted, same = step.at(deviates).log_weight(tangents)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-5)
    np.testing.assert_array_equal(met, same)
    some = np.array([4, 1])
    np.testing.assert_allclose(at.log_weight(tangents.rows(some), some)[0], found[some])


def test_centre_and_spread_are_those_of_the_filter(step: GaussianStep) -> None:
    """False alarm: 24 means by 4.4 standard errors and 24 spreads by 4.5, once in 2 000 seeds."""
    many = np.zeros((4000, len(HYPERPARAMETERS)))
    numbers = np.random.default_rng(8).standard_normal((4000, step.numbers(many)))
    states = step.at(many).tangents(numbers).states.reshape(4000, -1)
    at = WrittenOut.of(step, many[:1])
    spread = np.sqrt(np.diag(at.root[0].T @ at.root[0]))
    assert np.abs((states.mean(axis=0) - at.centre[0]) / spread).max() < 0.07
    np.testing.assert_allclose(states.std(axis=0) / spread, 1.0, atol=0.05)


def test_the_trend_s_density_is_that_of_its_gaussian(
    step: GaussianStep, deviates: np.ndarray
) -> None:
    at = WrittenOut.of(step, deviates)
    courses = drawn(at, 9)[1].states
    mean, covariance = joint_gaussian(*step.steps_of(deviates), WEAR_PRIOR.scales)
    wanted = [
        multivariate_normal.logpdf(course.ravel(), middle.ravel(), spread)
        for course, middle, spread in zip(courses, mean, covariance, strict=True)
    ]
    found = at.log_trend(np.stack([courses, courses]))
    constant = 0.5 * at.size * np.log(2 * np.pi)
    np.testing.assert_allclose(found - constant, [wanted, wanted], rtol=1e-6, atol=1e-5)
    some = np.array([4, 1])
    only = at.having_only(some).log_trend(courses[None, some])
    np.testing.assert_allclose(only[0], found[0, some])


def test_the_weight_is_that_of_all_tests_parts_and_the_trend_s(
    step: GaussianStep, deviates: np.ndarray
) -> None:
    at = WrittenOut.of(step, deviates)
    _, tangents = drawn(at, 7)
    weight, met = at.log_weight(tangents)
    on_ridges, on_tangents = at.log_trend(np.stack([met, tangents.states]))
    found = on_ridges - on_tangents
    for number, own in enumerate(tangents.nuisances):
        part, one = step.log_weight_of(number, tangents.states[:, number], own)
        np.testing.assert_allclose(one, met[:, number])
        found = found + part
    np.testing.assert_allclose(found, weight, rtol=1e-6, atol=1e-5)


def test_one_test_changes_the_trend_s_density_by_as_much_as_all_know(
    step: GaussianStep, deviates: np.ndarray
) -> None:
    at = WrittenOut.of(step, deviates)
    courses = np.stack([drawn(at, seed)[1].states for seed in (7, 8)])
    by = 0.1 * np.random.default_rng(9).standard_normal((2, DRAWS, 8))
    others = courses.copy()
    others[:, :, 1] += by
    rows = np.array([3, 0])
    found = at.trend_of(slice(8, 16), courses)(rows, by[:, rows])
    wanted = at.log_trend(others) - at.log_trend(courses)
    np.testing.assert_allclose(found, wanted[:, rows], rtol=1e-6, atol=1e-5)


def test_one_test_given_all_others_is_the_conditional_gaussian(step: GaussianStep) -> None:
    """False alarm: 64 covariances by 4.5 standard errors, once in 2 000 seeds."""
    many = np.zeros((4000, len(HYPERPARAMETERS)))
    at = WrittenOut.of(step, many[:1])
    numbers = np.random.default_rng(10).standard_normal((1, at.numbers))
    states = at.tangents(numbers).states
    whole = at.factor[0] @ at.factor[0].T
    block, rest = np.arange(8, 16), np.delete(np.arange(24), np.arange(8, 16))
    off = states.ravel() - at.centre[0]
    precision = whole[np.ix_(block, block)]
    away = np.linalg.solve(precision, whole[np.ix_(block, rest)] @ off[rest])
    at = at.having_only(np.zeros(4000, dtype=int))
    repeated = np.repeat(numbers[:, :24], 4000, axis=0)
    centre, drawn_away = at.given_others(
        slice(8, 16), np.repeat(states[:, 1], 4000, axis=0), repeated, np.random.default_rng(11)
    )
    np.testing.assert_allclose(centre[0], at.centre[0, block] - away, atol=1e-6)
    lower = np.linalg.cholesky(precision)
    standard = drawn_away @ lower
    np.testing.assert_allclose(np.cov(standard.T), np.eye(8), atol=0.1)


def test_some_draws_are_another_s(step: GaussianStep, deviates: np.ndarray) -> None:
    one, other = WrittenOut.of(step, deviates), WrittenOut.of(step, deviates[::-1])
    mixed = one.having(np.array([0, 4]), other, np.array([2, 3]))
    np.testing.assert_array_equal(mixed.centre[[0, 4]], other.centre[[2, 3]])
    np.testing.assert_array_equal(mixed.root[4], other.root[3])
    np.testing.assert_array_equal(mixed.trend[[1, 2, 3, 5]], one.trend[[1, 2, 3, 5]])


def test_a_covariance_that_is_none_has_no_weight(
    step: GaussianStep, deviates: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    def one_broken(*given: object) -> tuple[np.ndarray, np.ndarray]:
        mean, covariance = joint_gaussian(*given)
        covariance[2, 0, 0] = -1.0
        return mean, covariance

    monkeypatch.setattr(written_out, "joint_gaussian", one_broken)
    at = WrittenOut.of(step, deviates)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # what is not a number stays none
        weight, _ = at.log_weight(drawn(at, 9)[1])
    assert weight[2] == -np.inf
    assert np.isfinite(np.delete(weight, 2)).all()
