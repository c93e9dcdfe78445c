"""Gaussians of the loops, taken from the loops: against Gaussians and quadrature that are known."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from hdprog.inference.information import Linearised
from hdprog.inference.pareto_weights import pareto_weights, worth
from hdprog.trend import tilted_loops
from hdprog.trend.exact_likelihood import Nuisances
from hdprog.trend.gaussian_step import GaussianStep
from hdprog.trend.ridge_map import RidgeMap
from hdprog.trend.tilted_loops import _Cavity, _Gaussian, with_tilted_loops
from hdprog.trend.wear_coordinates import from_loop
from tests.trend.two_tests import (
    COUNTED,
    FIXED,
    T_I,
    Problem,
    straight,
    two_tests,
    with_a_count,
)


@pytest.fixture(scope="module")
def problem() -> Problem:
    return two_tests()


def joint(problem: Problem, step: GaussianStep) -> tuple[np.ndarray, np.ndarray]:
    """Mean (16,) and covariance (16, 16) of what the tests met, by a step's Gaussians."""
    precision = problem.prior.precision.copy()
    pull = precision @ problem.prior.mean.ravel()
    for place, test in enumerate(step.tests):
        block = slice(8 * place, 8 * place + 8)
        precision[block, block] += test.loop.precision
        pull[block] += test.loop.information
    covariance = np.linalg.inv(precision)
    return covariance @ pull, covariance


@dataclass(frozen=True)
class Known:
    """A Gaussian, other than the one that stands for it."""

    mean: np.ndarray
    precision: np.ndarray

    def log_likelihood(self, coordinates: np.ndarray, nuisances: np.ndarray) -> np.ndarray:
        off = from_loop(coordinates) - self.mean
        return -0.5 * np.einsum("di,ij,dj->d", off, self.precision, off)


def with_known(problem: Problem) -> tuple[GaussianStep, GaussianStep]:
    """A step whose Gaussians are off, and the right one."""
    mean, covariance = joint(problem, problem.step)
    rng = np.random.default_rng(12)
    off, right = [], []
    for place, test in enumerate(problem.step.tests):
        block = slice(8 * place, 8 * place + 8)
        lower = np.linalg.cholesky(covariance[block, block])
        more = np.linalg.solve(lower.T, np.sqrt(rng.uniform(0.0, 0.8, 8))[:, None] * np.eye(8))
        precision = 0.7 * test.loop.precision + more @ more.T
        centre = mean[block] + 0.5 * lower @ rng.standard_normal(8)
        off.append(replace(test, exact=Known(centre, precision)))
        loop = replace(test.loop, precision=precision, information=precision @ centre)
        right.append(replace(test, loop=loop))
    return problem.step.having(off), problem.step.having(right)


def errors(
    problem: Problem, found: GaussianStep, right: GaussianStep
) -> tuple[np.ndarray, np.ndarray]:
    """Of the means in spreads, and of the spreads by their ratio."""
    (mean, covariance), (known, spreads) = joint(problem, found), joint(problem, right)
    spread = np.sqrt(np.diag(spreads))
    return np.abs(mean - known) / spread, np.abs(np.sqrt(np.diag(covariance)) / spread - 1.0)


@pytest.mark.parametrize("cavity", [True, False])
def test_loops_that_are_gaussian_are_found(
    problem: Problem, monkeypatch: pytest.MonkeyPatch, cavity: bool
) -> None:
    """To a fortieth of a spread; and not where a test counts itself among the others."""
    monkeypatch.setattr(tilted_loops, "onto_ridges", straight)
    if not cavity:
        none = np.zeros((8, 8))
        monkeypatch.setattr(_Cavity, "of", lambda among, loop: _Cavity(among, none, none[0]))
    off, right = with_known(problem)
    before, _ = errors(problem, off, right)
    assert before.max() > 0.5
    found = with_tilted_loops(off, FIXED[0], np.random.default_rng(3))
    of_mean, of_spread = errors(problem, found, right)
    assert (of_mean.max() < 0.06 and of_spread.max() < 0.06) == cavity


def test_a_bend_that_all_tests_share_is_said_once(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each of two tests takes half of what is said of going round: a Gaussian here, too."""
    mean, covariance = joint(problem, problem.step)
    spread = np.sqrt(covariance[T_I, T_I])
    said, about = 2.0 / spread**2, mean[T_I] + 0.4 * spread

    def bent(maps: list[RidgeMap], tangents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return tangents, -0.5 * said * (tangents[..., T_I] - about) ** 2

    monkeypatch.setattr(tilted_loops, "onto_ridges", bent)
    off, gaussian = with_known(problem)
    tests = []
    for test in gaussian.tests:
        precision, information = test.loop.precision.copy(), test.loop.information.copy()
        precision[T_I, T_I] += 0.5 * said
        information[T_I] += 0.5 * said * about
        loop = replace(test.loop, precision=precision, information=information)
        tests.append(replace(test, loop=loop))
    found = with_tilted_loops(off, FIXED[0], np.random.default_rng(3))
    of_mean, of_spread = errors(problem, found, gaussian.having(tests))
    assert of_mean.max() < 0.06
    assert of_spread.max() < 0.06
    _, without = errors(problem, found, gaussian)
    assert without.max() > 0.2


def test_a_skewed_loop_has_the_mean_and_spread_of_quadrature(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the Gaussian of its own number, which was off, has the number's mean."""
    monkeypatch.setattr(tilted_loops, "onto_ridges", straight)
    step, before, spread = with_a_count(problem)
    found = with_tilted_loops(step, FIXED[0], np.random.default_rng(4))
    mean, covariance = joint(problem, found)
    expected, expected_sd = COUNTED
    assert (mean[T_I] - before) / spread == pytest.approx(expected, abs=0.04)
    assert np.sqrt(covariance[T_I, T_I]) / spread == pytest.approx(expected_sd, abs=0.04)
    assert abs(expected) > 0.15  # as it would be by the Gaussian that it had


def effective(step: GaussianStep) -> float:
    """How many of 4 000 draws of the step are worth anything."""
    at = step.at(np.repeat(FIXED, 4000, axis=0))
    numbers = np.random.default_rng(5).standard_normal((4000, step.numbers(FIXED)))
    weight, _ = pareto_weights(at.log_weight(at.tangents(numbers))[0])
    return worth(weight)


def test_draws_of_the_step_are_worth_more(problem: Problem) -> None:
    found = with_tilted_loops(problem.step, FIXED[0], np.random.default_rng(6))
    assert effective(found) > 1.5 * effective(problem.step)


@dataclass(frozen=True)
class Impossible:
    """Nowhere likely."""

    def log_likelihood(self, coordinates: np.ndarray, nuisances: np.ndarray) -> np.ndarray:
        return np.full(len(coordinates), -np.inf)


@dataclass(frozen=True)
class FarAway:
    """So sharp and so far off that hardly a draw has any weight."""

    point: np.ndarray

    def log_likelihood(self, coordinates: np.ndarray, nuisances: np.ndarray) -> np.ndarray:
        return -1e8 * np.sum((from_loop(coordinates) - self.point - 10.0) ** 2, axis=1)


def test_too_few_draws_leave_a_test_as_it_is(problem: Problem) -> None:
    first, second = problem.step.tests
    gone = (replace(first, exact=Impossible()), replace(second, exact=FarAway(second.point)))
    found = with_tilted_loops(problem.step.having(gone), FIXED[0], np.random.default_rng(7))
    for before, after in zip(gone, found.tests, strict=True):
        assert after is before


def test_a_loop_that_is_exact_is_left_alone(problem: Problem) -> None:
    exact = tuple(replace(one, exact=None) for one in problem.step.tests)
    found = with_tilted_loops(problem.step.having(exact), FIXED[0], np.random.default_rng(8))
    assert all(after is before for before, after in zip(exact, found.tests, strict=True))
    assert all(isinstance(test.own, Nuisances) for test in found.tests)


def test_a_loop_that_leans_where_it_leaves_all_open_has_a_top() -> None:
    """Else wear without bounds, by which predictions widen, would be believed the more."""
    among = _Gaussian(np.zeros(2), np.eye(2))
    cavity = _Cavity.of(among, Linearised(np.diag([0.0, 0.9]), np.zeros(2), 0.0))
    found = _Gaussian(np.array([0.5, 0.1]), np.diag([1.2, 1.0]))
    loop = cavity.loop_of(found)
    slope = loop.information - loop.precision @ found.mean
    assert 0.5 * slope @ np.linalg.solve(loop.precision, slope) < 3.0
    whole = np.diag([1.0, 0.1]) + loop.precision
    np.testing.assert_allclose(np.linalg.solve(whole, loop.information), found.mean)
