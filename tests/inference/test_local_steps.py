"""Local steps leave a known target unchanged, and a factor left out is caught."""

from __future__ import annotations

import numpy as np
from emcee import EnsembleSampler
from emcee.moves import MHMove
from scipy import stats

from hdprog.inference.mixture_proposal import LocalProposal, Mixture
from hdprog.inference.sampler import fresh_random_state

WALKERS, STEPS = 20_000, 15
# Narrow beside wide, as a shelf is beside a main mode: the way back picks another component.
MIXTURE = Mixture(
    log_weights=np.log([0.7, 0.3]),
    means=np.array([[0.0, 0.0], [1.5, 0.5]]),
    factors=np.array([[[0.5, 0.0], [0.2, 0.4]], [[2.0, 0.0], [-0.5, 1.5]]]),
)


class AsIfSymmetric(LocalProposal):
    """The same steps with the components' shares at both ends left out."""

    def __call__(
        self, position: np.ndarray, random: np.random.RandomState
    ) -> tuple[np.ndarray, np.ndarray]:
        proposed, factor = super().__call__(position, random)
        return proposed, np.zeros_like(factor)


def target(points: np.ndarray) -> np.ndarray:
    return -0.5 * (points**2).sum(axis=1)


def moved(kind: type[LocalProposal]) -> tuple[np.ndarray, np.ndarray]:
    """Where the steps alone lead draws of the target, and how far they have come."""
    rng = np.random.default_rng(11)
    start = rng.standard_normal((WALKERS, 2))
    sampler = EnsembleSampler(WALKERS, 2, target, moves=MHMove(kind(MIXTURE)), vectorize=True)
    sampler.random_state = fresh_random_state(rng)
    sampler.run_mcmc(start, STEPS, skip_initial_state_check=True)
    assert sampler.acceptance_fraction.mean() > 0.2
    last = sampler.get_chain()[-1]
    return last, last - start


def test_local_steps_leave_the_target_unchanged() -> None:
    after, way = moved(LocalProposal)
    assert way.std() > 0.5
    for axis in range(2):  # false alarm 1e-3 each
        assert stats.kstest(after[:, axis], "norm").pvalue > 1e-3


def test_the_check_catches_shares_left_out() -> None:
    after, _ = moved(AsIfSymmetric)
    assert min(stats.kstest(after[:, axis], "norm").pvalue for axis in range(2)) < 1e-6


def test_steps_are_by_the_component_where_a_walker_stands() -> None:
    for mean, factor in zip(MIXTURE.means, MIXTURE.factors, strict=True):
        far = Mixture(MIXTURE.log_weights, 1e3 * MIXTURE.means, MIXTURE.factors)
        position = np.tile(1e3 * mean, (4000, 1))
        proposed, ratio = LocalProposal(far)(position, np.random.RandomState(2))
        step = np.linalg.solve(factor, (proposed - position).T)
        np.testing.assert_allclose(ratio, 0.0, atol=1e-12)
        # Lengths even in their logarithm from 0.2 to 1.2: mean square 0.39, known to 2 %.
        np.testing.assert_allclose(step.var(axis=1), 0.39, atol=0.05)
        assert abs(np.corrcoef(step)[0, 1]) < 0.08
