"""Sampling all loops with the trend gives the posterior of the whole model, and weights do too.

The reference samples what two tests met directly, 16 numbers under fixed hyperparameters: the
dense Gaussian of the trend times the loops' own likelihoods, by emcee's moves, without the Gaussian
step, its ellipses or its weights.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
import pytest

from hdprog.inference.information import Linearised
from hdprog.inference.ridge_coordinates import from_unconstrained
from hdprog.physics.parameters import NAMES
from hdprog.trend import gaussian_step, joint_chains, joint_refit, wear_coordinates
from hdprog.trend.exact_likelihood import Nuisances
from hdprog.trend.hyperparameters import HyperparameterDraws
from hdprog.trend.joint_chains import Chains
from hdprog.trend.joint_refit import Effort, Met, begin_meeting
from hdprog.trend.ridge_map import RidgeMap, onto_ridges
from hdprog.trend.ridge_paths import RidgePath, Shift
from hdprog.trend.wear_coordinates import from_loop, to_loop
from tests.trend.stand_in import ALPHA, PRIOR
from tests.trend.two_tests import (
    COUNTED,
    FIXED,
    T_I,
    Problem,
    step_covariance,
    straight,
    two_tests,
    with_a_count,
)

LONG = Effort(200, 200, 0.0, 0.0)
SHORT = Effort(100, 100, 0.0, 0.0)  # enough for a fault to show


def fixed_draws() -> HyperparameterDraws:
    chains = np.tile(FIXED, (4, 100, 24, 1))
    return HyperparameterDraws(chains, 1.0, 1e4, 1e4, converged=True)


@pytest.fixture(scope="module")
def problem() -> Problem:
    return two_tests()


def sampled(problem: Problem, monkeypatch: pytest.MonkeyPatch, effort: Effort = LONG) -> Met:
    """Joint draws, about a thousand effective of long runs: spreads known to two hundredths."""
    monkeypatch.setattr(joint_refit, "HIGHEST_K", -1.0)
    monkeypatch.setattr(Chains, "_vary_hyperparameters", lambda chains: None)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # R-hat of what is held fixed
        found = begin_meeting(problem.step, fixed_draws(), np.random.default_rng(1), effort)()
    assert found.sampled
    return found


@pytest.fixture(scope="module")
def reference(problem: Problem) -> np.ndarray:
    """(draws, 16) by walkers that start from half the spread of the ridge's own draws."""
    from emcee import EnsembleSampler
    from emcee.moves import DEMove

    rng = np.random.default_rng(2)
    at = problem.step.at(np.repeat(FIXED, 96, axis=0))
    numbers = 0.5 * rng.standard_normal((96, problem.step.numbers(FIXED)))
    points = at.log_weight(at.tangents(numbers))[1].reshape(-1, 8)
    start = from_unconstrained(to_loop(points), ALPHA, PRIOR.softplus_scale).reshape(96, -1)
    sampler = EnsembleSampler(96, 16, problem.log_density, moves=DEMove(), vectorize=True)
    sampler.random_state = np.random.RandomState(3).get_state()
    sampler.run_mcmc(start, 5000)
    points, _ = problem.points(sampler.get_chain(discard=1500, thin=5, flat=True))
    return points.reshape(len(points), -1)


def shifts_and_ratios(found: np.ndarray, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    spread = reference.std(axis=0)
    shift = (found.mean(axis=0) - reference.mean(axis=0)) / spread
    return np.abs(shift), found.std(axis=0) / spread


def test_it_is_the_posterior_of_the_whole_model(
    problem: Problem, reference: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = sampled(problem, monkeypatch).measured
    shift, ratio = shifts_and_ratios(found.reshape(len(found), -1), reference)
    assert shift.max() < 0.1
    assert ratio.min() > 0.93
    assert ratio.max() < 1.07


def test_offers_to_some_chains_at_a_time_lead_to_the_same(
    problem: Problem, reference: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where there are many tests: a third of the chains a sweep."""
    monkeypatch.setattr(joint_chains, "_WRITTEN", 5)
    found = sampled(problem, monkeypatch).measured
    shift, ratio = shifts_and_ratios(found.reshape(len(found), -1), reference)
    assert shift.max() < 0.1
    assert ratio.min() > 0.93
    assert ratio.max() < 1.07


def test_without_the_slope_of_the_ridge_it_would_not_be(
    problem: Problem, reference: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The planted fault that the comparison has to notice."""

    def flat(maps: list[RidgeMap], tangents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found, log_slope = onto_ridges(maps, tangents)
        return found, np.where(np.isfinite(log_slope), 0.0, log_slope)

    monkeypatch.setattr(gaussian_step, "onto_ridges", flat)
    found = sampled(problem, monkeypatch, SHORT).measured
    shift, _ = shifts_and_ratios(found.reshape(len(found), -1), reference)
    assert shift.max() > 0.2


def test_shifts_that_forget_how_likely_the_states_are_would_be_noticed(
    problem: Problem, reference: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They run away at once."""
    monkeypatch.setattr(joint_chains, "_log_normal", lambda numbers: np.zeros(len(numbers)))
    found = sampled(problem, monkeypatch, Effort(30, 30, 0.0, 0.0)).measured
    _, ratio = shifts_and_ratios(found.reshape(len(found), -1), reference)
    assert ratio.max() > 1.15


@pytest.mark.parametrize("move", ["along", "turned"])
def test_shifts_that_forget_what_volumes_they_owe_would_be_noticed(
    problem: Problem, reference: np.ndarray, monkeypatch: pytest.MonkeyPatch, move: str
) -> None:
    """Going along friction's paths it lies elsewhere, turning beside them it is too narrow."""
    right = getattr(RidgePath, move)

    def forgetful(path: RidgePath, states: np.ndarray, *how: np.ndarray) -> Shift:
        shift: Shift = right(path, states, *how)
        return replace(shift, log_volume=np.zeros(len(states)))

    monkeypatch.setattr(RidgePath, move, forgetful)
    found = sampled(problem, monkeypatch, SHORT).measured
    shift, ratio = shifts_and_ratios(found.reshape(len(found), -1), reference)
    assert shift.max() > 0.2 if move == "along" else ratio.min() < 0.9


def test_jumps_of_thresholds_lead_to_the_same(
    problem: Problem, reference: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of thresholds that are well known here, so that they jump less far than else."""
    monkeypatch.setattr(joint_chains, "_NEAR_NONE", 1e6)
    monkeypatch.setattr(joint_chains, "_JUMPS", np.array([0.05, 0.2]))
    found = sampled(problem, monkeypatch).measured
    shift, ratio = shifts_and_ratios(found.reshape(len(found), -1), reference)
    assert shift.max() < 0.1
    assert ratio.min() > 0.93
    assert ratio.max() < 1.07


def test_teeth_stiffer_than_they_can_be_have_no_weight(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing in the loops speaks against a trend that lets teeth heal without end."""
    at = problem.step.at(np.repeat(FIXED, 50, axis=0))
    numbers = np.random.default_rng(5).standard_normal((50, problem.step.numbers(FIXED)))
    weight, met = at.log_weight(at.tangents(numbers))
    ratio = np.exp(met[..., NAMES.index("b")] - met[..., NAMES.index("K_F")]).max(axis=1)
    assert np.isfinite(weight).any()
    middle = float(np.median(ratio))
    monkeypatch.setattr(wear_coordinates, "STIFFEST_TEETH", middle)
    bounded, _ = at.log_weight(at.tangents(numbers))
    assert np.array_equal(bounded, np.where(ratio <= middle, weight, -np.inf))


def test_loops_that_are_gaussian_are_neither_weighted_nor_sampled(problem: Problem) -> None:
    gaussian = replace(
        problem.step, tests=tuple(replace(one, exact=None) for one in problem.step.tests)
    )
    found = begin_meeting(gaussian, fixed_draws(), np.random.default_rng(1), LONG)()
    assert found.pareto_k is None
    assert not found.sampled
    assert found.converged


@pytest.mark.parametrize("weighed", [True, False])
def test_what_is_a_tests_own_is_sampled_with_the_state(
    problem: Problem, monkeypatch: pytest.MonkeyPatch, weighed: bool
) -> None:
    """Against quadrature over (ξ, v), from a Gaussian of v that is off; left out, it shows."""
    monkeypatch.setattr(joint_refit, "HIGHEST_K", -1.0)
    monkeypatch.setattr(Chains, "_vary_hyperparameters", lambda chains: None)
    monkeypatch.setattr(gaussian_step, "onto_ridges", straight)
    if not weighed:
        monkeypatch.setattr(Nuisances, "log_density", lambda self, x, v: np.zeros(len(v)))
    step, mean, spread = with_a_count(problem)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        found = begin_meeting(step, fixed_draws(), np.random.default_rng(8), LONG)().measured
    drawn = (found[:, 0, T_I] - mean) / spread
    expected, expected_sd = COUNTED
    # By four seeds right draws come within 0.006 of both; wrong ones are 0.023 too narrow and more.
    close = abs(drawn.mean() - expected) < 0.02
    assert (close and abs(drawn.std() / expected_sd - 1.0) < 0.015) == weighed


@dataclass(frozen=True)
class Tilted:
    """The linearised loop itself, times exp(tilt·x): a Gaussian of the same spread, moved."""

    loop: Linearised
    point: np.ndarray
    tilt: np.ndarray

    def log_likelihood(self, coordinates: np.ndarray, nuisances: np.ndarray) -> np.ndarray:
        off = from_loop(coordinates) - self.point
        pull = self.loop.information - self.loop.precision @ self.point + self.tilt
        return off @ pull - 0.5 * np.einsum("di,ij,dj->d", off, self.loop.precision, off)


def test_weighted_draws_have_the_mean_that_is_known(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tilt of 0.4 spreads: 3 400 of 4 000 draws are effective, a mean errs by 0.017 of them."""
    monkeypatch.setattr(gaussian_step, "onto_ridges", straight)
    covariance = step_covariance(problem)
    spread = np.sqrt(np.diag(covariance))
    tilt = np.zeros(16)
    tilt[T_I] = 0.4 / spread[T_I]
    tilted = tuple(
        replace(test, exact=Tilted(test.loop, test.point, part))
        for test, part in zip(problem.step.tests, tilt.reshape(2, 8), strict=True)
    )
    step = replace(problem.step, tests=tilted)
    found = begin_meeting(step, fixed_draws(), np.random.default_rng(6), LONG)()
    assert not found.sampled
    assert found.worth is not None
    assert found.worth > 3000
    drawn = found.measured.reshape(len(found.measured), -1)
    plain = problem.prior.precision @ problem.prior.mean.ravel()
    plain += np.concatenate([test.loop.information for test in tilted])
    mean = covariance @ (plain + tilt)
    # Of 16 means none is so far off in a thousand seeds, resampling counted.
    assert np.abs((drawn.mean(axis=0) - mean) / spread).max() < 0.1
    assert (covariance @ tilt / spread)[T_I] == pytest.approx(0.4)
    assert drawn.std(axis=0) / spread == pytest.approx(1.0, abs=0.08)


def test_too_short_a_run_says_so(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(joint_refit, "HIGHEST_K", -1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        found = begin_meeting(
            problem.step, fixed_draws(), np.random.default_rng(1), Effort(4, 4, 200.0, 200.0)
        )()
    assert not found.converged


def test_without_a_possible_draw_it_says_so(problem: Problem) -> None:
    @dataclass(frozen=True)
    class Impossible:
        def log_likelihood(self, coordinates: np.ndarray, nuisances: np.ndarray) -> np.ndarray:
            return np.full(len(coordinates), -np.inf)

    nowhere = tuple(replace(one, exact=Impossible()) for one in problem.step.tests)
    found = begin_meeting(
        replace(problem.step, tests=nowhere), fixed_draws(), np.random.default_rng(1), LONG
    )()
    assert not found.converged


def test_without_sampling_the_step_itself_is_what_one_has(
    problem: Problem, reference: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joint_refit, "HIGHEST_K", -1.0)
    found = begin_meeting(problem.step, fixed_draws(), np.random.default_rng(1), joint_refit.NONE)()
    assert not found.sampled
    assert not found.converged
    drawn = found.measured.reshape(len(found.measured), -1)
    assert np.isfinite(drawn).all()
    # The step is wider than the posterior, not narrower, and lies where that lies.
    ratio = drawn.std(axis=0) / reference.std(axis=0)
    away = np.abs(drawn.mean(axis=0) - reference.mean(axis=0)) / drawn.std(axis=0)
    assert ratio.min() > 0.8
    assert away.max() < 1.5
