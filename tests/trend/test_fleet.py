"""Partial pooling: what other drives say becomes a drive's prior, no more and no less."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.physics.parameters import NAMES
from hdprog.trend.fleet import WITHIN, FleetPrior, Said, log_prior_of_spread
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters
from hdprog.trend.wear_prior import read_wear_prior
from hdprog.trend.what_tests_say import DEVIATES

SIZE = len(DEVIATES)
ALIKE, DIFFERENT = 0.055, 1.0
"""Scales of the spread within a fleet: the least of the shipped prior's, and any spread."""


def pooled(said: list[Said], scale: float) -> FleetPrior:
    """A fleet whose drives may differ by so much, in every deviate."""
    drives = [str(number) for number in range(len(said))]
    return FleetPrior.of(drives, said, np.full(said[0].information.size, scale))


def exactly(value: np.ndarray, precision: float) -> Said:
    """A drive whose tests know all its deviates equally well."""
    return Said(precision * np.eye(value.size), precision * value)


@pytest.mark.parametrize("scale", [ALIKE, DIFFERENT])
def test_drives_that_say_nothing_leave_the_shipped_prior(scale: float) -> None:
    fleet = pooled([exactly(np.zeros(4), 0.0)] * 2, scale)
    # Some 1 500 sweeps: means within 0.1, variances within 0.1.
    np.testing.assert_allclose(fleet.mean, 0.0, atol=0.1)
    np.testing.assert_allclose(fleet.covariance, np.eye(4), atol=0.1)


@pytest.mark.parametrize("scale", [ALIKE, DIFFERENT])
def test_many_precise_drives_overrule_the_shipped_prior(scale: float) -> None:
    rng = np.random.default_rng(0)
    told = np.array([1.5, -2.0, 0.0]) + 0.3 * rng.standard_normal((60, 3))
    fleet = pooled([exactly(one, 1e4) for one in told], scale)
    np.testing.assert_allclose(fleet.mean, told.mean(axis=0), atol=0.05)
    np.testing.assert_allclose(np.sqrt(np.diag(fleet.covariance)), 0.3, rtol=0.3)


def test_one_drive_tells_part() -> None:
    fleet = pooled([exactly(np.array([2.0, 0.0]), 1e6)], DIFFERENT)
    assert 0.5 < fleet.mean[0] < 1.6
    assert 0.5 < fleet.covariance[0, 0] < 1.1


def test_of_drives_that_are_alike_one_tells_most() -> None:
    fleet = pooled([exactly(np.array([2.0, 0.0]), 1e6)], ALIKE)
    assert 1.5 < fleet.mean[0] < 2.0
    assert fleet.covariance[0, 0] < 0.5


def test_drives_said_to_be_alike_can_show_that_they_are_not() -> None:
    """Six drives that spread as any drives do: what is passed on is as wide, within a half."""
    told = np.random.default_rng(6).standard_normal((6, 40))
    fleet = pooled([exactly(one, 1e6) for one in told], ALIKE)
    found = np.diag(fleet.covariance)
    assert 0.5 < float(np.mean(found)) < 1.5


def test_deviates_known_by_their_sum_alone_stay_together() -> None:
    """Pace and loading, of which tests know the product: the sum is learnt, the parts are not."""
    along = np.array([[1.0, 1.0], [1.0, 1.0]])
    rng = np.random.default_rng(1)
    said = [Said(400 * along, 400 * (3.0 + 0.1 * rng.standard_normal()) * np.ones(2))] * 12
    fleet = pooled(said, DIFFERENT)
    spread_of_sum = np.sqrt(fleet.covariance.sum())
    assert fleet.mean.sum() == pytest.approx(3.0, abs=0.3)
    assert spread_of_sum < 0.5
    assert np.sqrt(fleet.covariance[0, 0]) > 0.4


@pytest.mark.parametrize("scale", [ALIKE, DIFFERENT])
@pytest.mark.parametrize("drives", [1, 6])
def test_the_next_drive_falls_where_the_fleet_says(drives: int, scale: float) -> None:
    """Normal scores of the next drive's 40 deviates over 12 fleets; a false alarm in 1 000."""
    rng = np.random.default_rng(drives)
    scores, size = [], 40
    chances = np.exp(log_prior_of_spread(np.array([scale]))[:, 0])
    for _ in range(12):
        share = 1.0 - rng.choice(WITHIN, p=chances / chances.sum(), size=size) ** 2
        mean = np.sqrt(share) * rng.standard_normal(size)
        own = mean + np.sqrt(1 - share) * rng.standard_normal((drives + 1, size))
        precision = np.exp(rng.uniform(-1, 3, size=(drives, size)))
        told = own[:-1] + rng.standard_normal((drives, size)) / np.sqrt(precision)
        said = [Said(np.diag(p), p * y) for y, p in zip(told, precision, strict=True)]
        fleet = pooled(said, scale)
        scores.extend((own[-1] - fleet.mean) / np.sqrt(np.diag(fleet.covariance)))
    found = np.array(scores)
    error = 3.3 / np.sqrt(found.size)
    assert abs(found.mean()) < error
    # The predictive is a mixture of spreads: its variance is right, its tails are longer.
    assert abs((found**2).mean() - 1) < error * (found**2).std()


def test_a_prior_is_divided_out_of_the_draws() -> None:
    """Draws of the product of a prior and a likelihood give the likelihood back."""
    rng = np.random.default_rng(3)
    mean, covariance = np.array([0.7, 0.0]), np.array([[0.4, 0.1], [0.1, 0.9]])
    likelihood = Said(np.array([[40.0, 5.0], [5.0, 8.0]]), np.array([-30.0, 2.0]))
    centre, spread = likelihood.posterior(mean, covariance)
    draws = rng.multivariate_normal(centre, spread, size=200_000)
    said = Said.of(draws, mean, covariance, 200_000.0)
    np.testing.assert_allclose(said.precision, likelihood.precision, rtol=0.03)
    np.testing.assert_allclose(said.information, likelihood.information, rtol=0.05, atol=0.2)


def test_tests_that_say_nothing_add_nothing() -> None:
    """400 draws from the prior itself: the edge of chance is passed in few of 17 directions."""
    rng = np.random.default_rng(4)
    passed = 0
    for _ in range(50):
        said = Said.of(rng.standard_normal((400, SIZE)), np.zeros(SIZE), np.eye(SIZE), 400.0)
        passed += np.linalg.matrix_rank(said.precision)
    # 7 in 850 come out; 17 would once in 1 000 (Poisson).
    assert passed < 17


def test_the_wear_prior_takes_the_fleets_place() -> None:
    shipped, count = read_wear_prior(), len(HYPERPARAMETERS)
    rng = np.random.default_rng(5)
    root = 0.3 * rng.standard_normal((SIZE, SIZE)) + np.eye(SIZE)
    fleet = FleetPrior(("a", "b"), rng.standard_normal(SIZE), root @ root.T)
    prior = shipped.learnt_from(fleet).following(2)
    assert prior.identity == shipped.identity
    standard = rng.standard_normal((200_000, count))
    values = Hyperparameters.of(standard, prior)
    deviates = prior.deviates(standard)
    np.testing.assert_allclose(values.volatility, shipped.volatility.at(deviates[:, 4]))
    # The loadings, drawn as the trend takes them, have the fleet's mean and covariance with the
    # hyperparameters (200 000 draws; five standard errors).
    spread = np.array([shipped.loadings[name].sd for name in NAMES])
    drawn = values.loading_mean + values.loading_sd * rng.standard_normal(
        (200_000, SIZE - count + 2)
    )
    loadings = (drawn[:, : len(NAMES)] - shipped.loading_mean) / spread
    np.testing.assert_allclose(loadings.mean(axis=0), fleet.mean[count:], atol=0.03)
    crossed = np.cov(np.hstack([deviates, loadings]).T)
    np.testing.assert_allclose(crossed[:count], fleet.covariance[:count], atol=0.05)
    np.testing.assert_allclose(np.diag(crossed), np.diag(fleet.covariance), atol=0.05)


def weak_fleet(rng: np.random.Generator, drives: int) -> tuple[np.ndarray, FleetPrior]:
    """The next drive's deviates, and what drives made of them that know theirs hardly at all."""
    share = rng.uniform(size=SIZE)
    mean = np.sqrt(share) * rng.standard_normal(SIZE)
    own = mean + np.sqrt(1 - share) * rng.standard_normal((drives + 1, SIZE))
    precision = np.exp(rng.uniform(np.log(0.03), np.log(0.3), size=(drives, SIZE)))
    told = own[:-1] + rng.standard_normal((drives, SIZE)) / np.sqrt(precision)
    said = []
    for y, p in zip(told, precision, strict=True):
        draws = p * y / (1 + p) + rng.standard_normal((600, SIZE)) / np.sqrt(1 + p)
        said.append(Said.of(draws, np.zeros(SIZE), np.eye(SIZE), 600.0))
    return own[-1], pooled(said, DIFFERENT)


def test_what_many_drives_hardly_know_adds_up() -> None:
    """Posteriors 1.5 to 14 % narrower than the prior, 40 drives: false alarm 1 in 1 000."""
    rng = np.random.default_rng(7)
    fleets = [weak_fleet(rng, 40) for _ in range(8)]
    truth = np.concatenate([one for one, _ in fleets])
    error = truth - np.concatenate([fleet.mean for _, fleet in fleets])
    scores = error / np.concatenate([np.sqrt(np.diag(fleet.covariance)) for _, fleet in fleets])
    spread = 3.3 * (scores**2).std() / np.sqrt(scores.size)
    assert abs((scores**2).mean() - 1) < spread
    # Exact division comes to about 0.7 of the prior's squares; nothing learnt would be 1.
    assert np.mean(error**2) < 0.85 * np.mean(truth**2)


def test_a_shift_that_all_drives_agree_on_is_learnt_within_reach() -> None:
    """Each says of one deviate −0.35 ± 0.95: together they move it, but not past their draws."""
    rng = np.random.default_rng(0)
    said = []
    for _ in range(40):
        draws = rng.standard_normal((600, SIZE))
        draws[:, 5] = -0.35 + 0.95 * draws[:, 5]
        said.append(Said.of(draws, np.zeros(SIZE), np.eye(SIZE), 600.0))
    fleet = pooled(said, DIFFERENT)
    assert -2.5 < fleet.mean[5] < -1.0
    others = np.delete(fleet.mean, 5)
    assert np.abs(others).max() < 1.0
