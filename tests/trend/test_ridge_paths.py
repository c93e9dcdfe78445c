"""Paths of joint modes: straight for Gaussians, along the ridge for loops, volumes unchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.inference.information import Linearised
from hdprog.physics.parameters import NAMES
from hdprog.trend import relinearise
from hdprog.trend.ridge_map import onto_ridges
from hdprog.trend.ridge_paths import RidgePath, _rising, ridge_paths
from hdprog.trend.wear_coordinates import to_loop
from tests.trend.stand_in import NEW, WEAR
from tests.trend.two_tests import FIXED, Problem, step_covariance, two_tests, worn_by

K_F, T_T = NAMES.index("K_F"), NAMES.index("T_T")
SEVERAL = 3.0  # spreads


@pytest.fixture(scope="module")
def problem() -> Problem:
    return two_tests()


@pytest.fixture(scope="module")
def paths(problem: Problem) -> tuple[RidgePath, ...]:
    return ridge_paths(problem.step, FIXED[0])


def of_cups(paths: tuple[RidgePath, ...]) -> RidgePath:
    return next(path for path in paths if path.share.reshape(2, -1)[:, K_F].any())


def test_a_shift_changes_the_place_by_what_is_asked_and_back_again(
    paths: tuple[RidgePath, ...],
) -> None:
    rng = np.random.default_rng(1)
    for path in paths:
        states = path.tangents[0] + 0.3 * rng.standard_normal((20, path.share.size))
        states = states.reshape(20, 2, -1)
        by = 4.0 * path.spread * rng.standard_normal(20)
        shift = path.along(states, by)
        there = states + shift.states
        assert shift.states.reshape(20, -1) @ path.share == pytest.approx(by, abs=1e-9)
        back = path.along(there, -by)
        assert there + back.states == pytest.approx(states, abs=1e-8)
        assert back.log_volume == pytest.approx(-shift.log_volume, abs=1e-9)


def test_volumes_change_as_it_is_said(paths: tuple[RidgePath, ...]) -> None:
    for path in paths:
        state = path.tangents.mean(axis=0) + 0.1
        steps = 1e-6 * np.eye(state.size)
        around = np.concatenate([state + steps, state - steps]).reshape(-1, 2, 8)
        shift = path.along(around, np.full(len(around), 1.3 * path.spread))
        plus, minus = np.split((around + shift.states).reshape(len(around), -1), 2)
        _, log_size = np.linalg.slogdet((plus - minus) / 2e-6)
        assert log_size == pytest.approx(shift.log_volume.mean(), abs=1e-4)


def test_a_turn_leaves_the_place_and_what_is_across(paths: tuple[RidgePath, ...]) -> None:
    rng = np.random.default_rng(3)
    for path in paths:
        states = (path.tangents[1] + 0.1 * rng.standard_normal((20, path.share.size))).reshape(
            20, 2, -1
        )
        fresh = rng.standard_normal((20, path.beside.shape[1]))
        turned = path.turned(states, fresh, np.full(20, 0.7)).states.reshape(20, -1)
        assert turned @ path.share == pytest.approx(0.0, abs=1e-9)
        across = turned - turned @ path.beside @ path.beside.T
        assert across == pytest.approx(0.0, abs=1e-9)
        assert np.abs(turned).max() > 0.0


def test_numbers_beside_that_are_normal_stay_so_when_they_are_turned(
    paths: tuple[RidgePath, ...],
) -> None:
    """What a turn owes is what the normal density of the numbers changes by."""
    rng = np.random.default_rng(4)
    path = of_cups(paths)
    mode, root = path.tangents[1], path.roots[1]
    numbers, fresh = rng.standard_normal((2, 4000, path.beside.shape[1]))
    states = (mode + numbers @ root.T @ path.beside.T).reshape(4000, 2, -1)
    shift = path.turned(states, fresh, rng.uniform(0.0, 1.5, 4000))
    there = (states + shift.states).reshape(4000, -1)
    turned = np.linalg.solve(root, ((there - mode) @ path.beside).T).T
    assert np.cov(turned.T) == pytest.approx(np.eye(turned.shape[1]), abs=0.1)
    owed = 0.5 * np.sum(turned**2 - numbers**2, axis=1)
    assert shift.log_volume == pytest.approx(owed, abs=1e-6)


def heights(problem: Problem, states: np.ndarray) -> np.ndarray:
    """Log posterior of loops and trend, own numbers at their best, of tangents (draws, 2, 8)."""
    met, _ = onto_ridges([test.ridge for test in problem.step.tests], states)
    off = (met - problem.prior.mean).reshape(len(met), -1)
    found = -0.5 * np.einsum("di,ij,dj->d", off, problem.prior.precision, off)
    for number, test in enumerate(problem.tests):
        found = found + [test.linearise(to_loop(one)).log_likelihood for one in met[:, number]]
    return found


def test_along_the_path_of_the_cups_one_stays_on_the_ridge(
    problem: Problem, paths: tuple[RidgePath, ...]
) -> None:
    """Three spreads away the posterior has fallen by what spreads are; straight on, farther."""
    path = of_cups(paths)
    start = np.stack([test.point for test in problem.step.tests])[None]
    by = np.array([-SEVERAL, SEVERAL]) * path.spread
    bent = np.repeat(start, 2, axis=0)
    bent = bent + path.along(bent, by).states
    covariance = step_covariance(problem)
    way = (covariance @ path.share / (path.share @ covariance @ path.share)).reshape(2, 8)
    straight = start + by[:, None, None] * way
    top = heights(problem, start)
    fallen, fallen_straight = top - heights(problem, bent), top - heights(problem, straight)
    assert (fallen < SEVERAL**2).all()
    assert (fallen_straight > 1.5 * fallen).all()


def test_what_lies_beside_is_taken_along() -> None:
    """Six tests of a nearly new drive, whose thresholds may be next to none or much.

    Scattered as they may be about one mode, states become such as may be about the other. Left as
    they were, a tenth of them would fall by forty.
    """
    problem = worn_by([0.05, 0.08, 0.1, 0.15, 0.2, 0.2], NEW + 0.1 * WEAR)
    paths = ridge_paths(problem.step, FIXED[0])
    path = next(one for one in paths if one.share.reshape(6, -1)[:, T_T].any())
    middle, rng = len(path.places) // 2, np.random.default_rng(5)
    off = rng.standard_normal((100, path.beside.shape[1])) @ path.roots[middle].T
    states = (path.tangents[middle] + off @ path.beside.T).reshape(100, 6, -1)
    shift = path.along(states, np.full(100, 2.0 * path.spread))
    before, there = heights(problem, states), states + shift.states
    taken, left = (heights(problem, one) - before for one in (there, there - shift.beside))
    assert np.quantile(taken, 0.1) > -15.0
    assert np.quantile(left, 0.1) < -30.0


def test_a_path_comes_back_from_thresholds_that_no_record_sees() -> None:
    """Records to 63 Nm, and teeth that are met at 80: any threshold beyond the records will do."""
    start = NEW + 0.7 * WEAR
    start[T_T] = 40.0  # half of it in Nm
    problem = worn_by([0.0, 0.0], start)
    paths = ridge_paths(problem.step, FIXED[0])
    path = next(one for one in paths if one.share.reshape(2, -1)[:, T_T].any())
    assert path.places[0] < 30.0
    assert path.places[-1] > 80.0
    assert path.spread > 20.0


def linearised(loop: Linearised, point: np.ndarray) -> Linearised:
    """A Gaussian loop itself, as high as it is at the point."""
    height = point @ (loop.information - 0.5 * loop.precision @ point)
    return Linearised(loop.precision, loop.information, float(height))


def test_of_gaussian_loops_it_is_the_straight_line_of_regression(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    tests = [replace(one, exact=None, evidence=one.loop) for one in problem.step.tests]
    monkeypatch.setattr(relinearise, "linearise", linearised)
    path = of_cups(ridge_paths(replace(problem.step, tests=tuple(tests)), FIXED[0]))
    covariance = step_covariance(problem)
    spread = float(np.sqrt(path.share @ covariance @ path.share))
    way = covariance @ path.share / spread**2
    assert path.spread == pytest.approx(spread, rel=0.1)
    gone = np.diff(path.tangents, axis=0) / np.diff(path.places)[:, None]
    assert np.abs(gone - way).max() < 0.01 * np.abs(way).max()


def test_a_path_ends_where_its_place_turns_back() -> None:
    places = np.array([3.0, 1.0, 2.0, 4.0, 5.0, 4.5])
    assert _rising(places, 2, 0.1) == slice(1, 5)
    assert _rising(np.array([1.0, 1.01, 1.02]), 1, 0.1) == slice(1, 2)
    assert _rising(np.array([1.0, np.nan, 2.0, 3.0]), 2, 0.1) == slice(2, 4)
