"""Proposals weighed by importance tell of the target, and teach the next proposal."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.inference.independent_steps import IndependentSteps
from hdprog.inference.mixture_proposal import Mixture, fit_mixture
from hdprog.inference.sampler import EnsembleState, fresh_random_state, sample_ensembles
from hdprog.inference.weighed_proposals import ENOUGH, WeighedProposals

DIMENSIONS = 4


def bent(points: np.ndarray) -> np.ndarray:
    """A banana: no Gaussian follows it."""
    first, second = points[:, 0], points[:, 1]
    rest = (points[:, 2:] ** 2).sum(axis=1)
    return -0.5 * (first**2 + ((second - first**2) / 0.5) ** 2 + rest)


def exactly(count: int, rng: np.random.Generator) -> np.ndarray:
    points = rng.standard_normal((count, DIMENSIONS))
    points[:, 1] = 0.5 * points[:, 1] + points[:, 0] ** 2
    return points


def wide(rng: np.random.Generator) -> Mixture:
    return fit_mixture(1.3 * exactly(400, rng), 1, rng)


def acceptance(mixture: Mixture, rng: np.random.Generator) -> float:
    """Share of independent proposals that are accepted from draws of the target."""
    here = exactly(4000, rng)
    there = mixture.draw(4000, np.random.RandomState(1))
    gain = bent(there) - mixture.log_density(there) - (bent(here) - mixture.log_density(here))
    return float(np.exp(np.minimum(gain, 0.0)).mean())


def test_resampled_proposals_are_draws_of_the_target() -> None:
    rng = np.random.default_rng(3)
    mixture = wide(rng)
    positions = mixture.draw(60_000, np.random.RandomState(2))
    told = WeighedProposals(positions, bent(positions) - mixture.log_density(positions))
    found = told.resampled(100_000, rng)
    truth = exactly(400_000, rng)
    # Worth 5 000 draws at least: four standard errors of a share, at each decile and coordinate
    # (36 of them: false alarm 2e-3).
    for mine, theirs in zip(found.T, truth.T, strict=True):
        deciles = np.quantile(theirs, np.arange(1, 10) / 10)
        below = (mine[:, None] < deciles).mean(axis=0)
        np.testing.assert_allclose(below, np.arange(1, 10) / 10, atol=4 * 0.5 / np.sqrt(5000))
    assert len(found) > 2 * 5000


def test_no_proposal_outweighs_all_others() -> None:
    log_weight = np.zeros(10_000)
    log_weight[7] = 40.0
    positions = np.arange(10_000.0)[:, None]
    found = WeighedProposals(positions, log_weight).resampled(1000, np.random.default_rng(0))
    assert len(found) <= 4
    outside = WeighedProposals(positions, np.full(10_000, -np.inf))
    assert outside.resampled(1000, np.random.default_rng(0)).shape == (0, 1)


def test_proposals_of_several_processes_are_put_together() -> None:
    one = WeighedProposals(np.zeros((3, 2)), np.arange(3.0))
    both = WeighedProposals.together([one, None, one])
    assert both is not None
    assert both.positions.shape == (6, 2)
    np.testing.assert_array_equal(both.log_weight, [0.0, 1.0, 2.0, 0.0, 1.0, 2.0])
    assert WeighedProposals.together([None, None]) is None
    many = WeighedProposals(np.zeros((ENOUGH, 2)), np.zeros(ENOUGH))
    enough = WeighedProposals.together([many, one])
    assert enough is not None
    assert len(enough.positions) == ENOUGH


def test_a_stretch_tells_all_that_was_proposed() -> None:
    rng = np.random.default_rng(5)
    mixture = wide(rng)
    evaluated = 0

    def counted(points: np.ndarray) -> np.ndarray:
        nonlocal evaluated
        evaluated += len(points)
        return bent(points)

    state = EnsembleState(exactly(40, rng).reshape(2, 20, -1), fresh_random_state(rng))
    stretch = sample_ensembles(counted, state, 30, mixture)
    assert stretch.evaluations == evaluated
    told = stretch.proposed
    assert told is not None
    assert len(told.positions) > 30 * 40 * 0.6
    expected = bent(told.positions) - mixture.log_density(told.positions)
    np.testing.assert_allclose(told.log_weight, expected, rtol=0, atol=1e-12)
    first = sample_ensembles(bent, state, 5)
    assert first.proposed is None


def test_a_long_stretch_tells_enough_and_no_more() -> None:
    rng = np.random.default_rng(6)
    state = EnsembleState(exactly(40, rng).reshape(2, 20, -1), fresh_random_state(rng))
    told = sample_ensembles(bent, state, 1000, wide(rng)).proposed
    assert told is not None
    assert ENOUGH <= len(told.positions) < ENOUGH + 400


def test_weighed_proposals_teach_more_than_the_chains_that_took_them() -> None:
    rng = np.random.default_rng(8)
    mixture = wide(rng)
    state = EnsembleState(exactly(80, rng).reshape(4, 20, -1), fresh_random_state(rng))
    stretch = sample_ensembles(bent, state, 60, mixture)
    assert stretch.proposed is not None
    by_chains = fit_mixture(stretch.chains.reshape(-1, DIMENSIONS), 6, rng)
    by_proposals = fit_mixture(stretch.proposed.resampled(6000, rng), 6, rng)
    before, chains, proposals = (acceptance(one, rng) for one in (mixture, by_chains, by_proposals))
    assert before < chains < proposals


@pytest.mark.parametrize("walkers", [20, 288, 400])
def test_steps_are_evaluated_ahead_and_taken_one_by_one(walkers: int) -> None:
    """Whatever share of a call a step is, each walker gets proposals of its own."""
    rng = np.random.default_rng(9)
    calls = []

    def counted(points: np.ndarray) -> np.ndarray:
        calls.append(len(points))
        return bent(points)

    class Model:
        log_prob_fn = staticmethod(counted)
        random = np.random.RandomState(4)

    class State:
        coords = exactly(walkers, rng)
        log_prob = bent(coords)

    move = IndependentSteps(wide(rng))
    for step in range(1, 31):
        before = State.coords.copy()
        _, taken = move.propose(Model, State)
        assert ((State.coords != before).any(axis=1) == taken).all()
        np.testing.assert_allclose(State.log_prob, bent(State.coords), rtol=0, atol=1e-12)
        assert sum(calls) == (step + move.steps_ahead) * walkers
    assert set(calls) == {-(-288 // walkers) * walkers}
