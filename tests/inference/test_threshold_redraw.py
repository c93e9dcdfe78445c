"""The redraw of the threshold leaves a known posterior unchanged, and a wrong one is caught."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from emcee import EnsembleSampler
from emcee.moves import MHMove
from scipy import stats

from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.sampler import RidgePosterior, fresh_random_state
from hdprog.inference.threshold_redraw import ThresholdRedraw
from tests.inference.test_likelihood import likelihood

T_T, WALKERS, STEPS = 4, 12_000, 12


class PriorAlone(LoopLikelihood):
    """A record that tells of nothing but whether the threshold lies far beyond it."""

    def log_likelihood(self, points: np.ndarray) -> np.ndarray:
        return np.where(points[:, T_T] > ThresholdRedraw(self).lowest + 0.5, np.log(3.0), 0.0)


@dataclass(frozen=True)
class AsIfSymmetric(ThresholdRedraw):
    """The same move with the densities of the ways there and back left out."""

    def __call__(
        self, position: np.ndarray, random: np.random.RandomState
    ) -> tuple[np.ndarray, np.ndarray]:
        proposed, factor = super().__call__(position, random)
        return proposed, np.where(np.isfinite(factor), 0.0, -np.inf)


def moved(kind: type[ThresholdRedraw]) -> tuple[np.ndarray, np.ndarray]:
    """Positions drawn from the posterior, and where the move alone leads them."""
    plain = likelihood(1e-5)
    model = PriorAlone(plain.reduced, plain.prior, plain.alpha, plain.noise)
    posterior, rng = RidgePosterior(model), np.random.default_rng(3)
    drawn = np.hstack([model.prior.sample(5 * WALKERS, rng), rng.logistic(size=(5 * WALKERS, 1))])
    mean, sd = model.prior.mean[T_T], model.prior.sd[T_T]
    above = stats.truncnorm((kind(model).lowest - mean) / sd, np.inf, mean, sd)
    drawn[:, T_T] = above.rvs(len(drawn), random_state=rng)
    kept = 3 * rng.random(len(drawn)) < np.exp(model.log_likelihood(drawn))
    drawn = drawn[kept & model.supported(drawn)][:WALKERS]
    start = np.array([posterior.position(point) for point in drawn])
    sampler = EnsembleSampler(WALKERS, 9, posterior, moves=MHMove(kind(model)), vectorize=True)
    sampler.random_state = fresh_random_state(rng)
    sampler.run_mcmc(start, STEPS, skip_initial_state_check=True)
    assert sampler.acceptance_fraction.mean() > 0.2
    return drawn, posterior.points(sampler.get_chain()[-1])


def test_redraws_leave_the_posterior_unchanged() -> None:
    before, after = moved(ThresholdRedraw)
    others = [index for index in range(9) if index != T_T]
    np.testing.assert_allclose(after[:, others], before[:, others], atol=1e-8)
    assert np.ptp(after[:, T_T] - before[:, T_T]) > 1
    # False alarm 1e-3.
    assert stats.ks_2samp(before[:, T_T], after[:, T_T]).pvalue > 1e-3


def test_the_check_catches_densities_left_out() -> None:
    before, after = moved(AsIfSymmetric)
    assert stats.ks_2samp(before[:, T_T], after[:, T_T]).pvalue < 1e-6


def test_walkers_below_the_record_s_end_stay() -> None:
    model = likelihood(1e-5)
    redraw, posterior = ThresholdRedraw(model), RidgePosterior(model)
    inside, beyond = model.prior_mean.copy(), model.prior_mean.copy()
    inside[T_T], beyond[T_T] = redraw.lowest - 0.1, redraw.lowest + 0.1
    position = np.array([posterior.position(point) for point in (inside, beyond)])
    proposed, factor = redraw(position, np.random.RandomState(1))
    np.testing.assert_array_equal(proposed[0], position[0])
    assert factor[0] == -np.inf
    assert np.isfinite(factor[1])
    assert posterior.points(proposed)[1, T_T] > redraw.lowest


class Nothing(LoopLikelihood):
    """A record that tells of nothing at all."""

    def log_likelihood(self, points: np.ndarray) -> np.ndarray:
        return np.zeros(len(points))


def test_without_data_every_redraw_that_lands_is_taken() -> None:
    """It draws from the prior: density and ways there and back cancel, whatever the Jacobian.

    Also between 0.85 of the largest torque and the torque itself, where the ridge coordinates hang
    on the threshold.
    """
    plain = likelihood(1e-5)
    prior = replace(plain.prior, mean=plain.prior.mean.copy(), sd=plain.prior.sd.copy())
    model = Nothing(plain.reduced, prior, plain.alpha, plain.noise)
    lowest, largest = ThresholdRedraw(model).lowest, plain.reduced.path.largest
    prior.mean[T_T], prior.sd[T_T] = lowest + 0.5, 1.0
    rng = np.random.default_rng(4)
    drawn = np.hstack([prior.sample(400, rng), rng.logistic(size=(400, 1))])
    posterior = RidgePosterior(model)
    drawn = drawn[model.supported(drawn) & (drawn[:, T_T] > lowest)]
    position = np.array([posterior.position(point) for point in drawn])
    proposed, factor = ThresholdRedraw(model)(position, np.random.RandomState(2))
    before, after = posterior(position), posterior(proposed)
    landed = np.isfinite(after)
    assert landed.mean() > 0.9
    np.testing.assert_allclose((after - before + factor)[landed], 0.0, atol=1e-8)
    inside = [
        prior.to_physical(points[:, :8])["T_T"] < largest
        for points in (drawn, posterior.points(proposed))
    ]
    assert np.mean(inside[0] != inside[1]) > 0.2
