"""Exact Hamiltonian steps leave the cut-off Gaussian unchanged; a wrong one is caught."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm

from hdprog.inference.truncated_gaussian import quarter_turn, sample_weights
from hdprog.physics.parameters import FloatArray

DRAWS = 4000


def chains(precision: FloatArray, pull: FloatArray, seed: int) -> FloatArray:
    """Draws (chains, DRAWS, size), each chain of a target of its own."""
    rng = np.random.default_rng(seed)
    weights, found = np.ones(pull.shape), []
    for _ in range(DRAWS):
        weights = quarter_turn(precision, pull, weights, rng)
        found.append(weights)
    return np.stack(found, axis=1)


def test_one_weight_has_the_moments_of_a_cut_off_gaussian() -> None:
    """Within 5 standard errors of 4 000 nearly independent draws: false alarms below 1e-5."""
    means = np.array([[-1.5], [0.3], [2.0]])
    for [mean], draws in zip(means, chains(np.ones((3, 1, 1)), means, 1)[:, :, 0], strict=True):
        ratio = norm.pdf(-mean) / norm.sf(-mean)
        expected = mean + ratio
        variance = 1 - ratio * (ratio + mean)
        assert (draws >= 0).all()
        assert draws.mean() == pytest.approx(expected, abs=5 * math.sqrt(variance / DRAWS))
        assert draws.var() == pytest.approx(variance, rel=0.2)


def test_correlated_weights_agree_with_rejection() -> None:
    """Means and shares within 0.06: 5 standard errors for an autocorrelation time up to 3."""
    precision = np.array([[2.0, 1.2, 0.0], [1.2, 1.5, -0.6], [0.0, -0.6, 1.0]])
    pull = np.array([0.5, -0.2, 0.4])
    [draws] = chains(precision[None], pull[None], 4)
    rng = np.random.default_rng(0)
    covariance = np.linalg.inv(precision)
    free = rng.multivariate_normal(covariance @ pull, covariance, size=400_000)
    kept = free[(free >= 0).all(axis=1)]
    np.testing.assert_allclose(draws.mean(axis=0), kept.mean(axis=0), atol=0.06)
    np.testing.assert_allclose(draws.std(axis=0), kept.std(axis=0), atol=0.06)
    both = np.corrcoef(draws.T)[0, 1] - np.corrcoef(kept.T)[0, 1]
    assert abs(both) < 0.1
    # The negative control: Gaussians that are clipped at zero are something else.
    clipped = np.maximum(free, 0.0)
    assert np.abs(clipped.mean(axis=0) - kept.mean(axis=0)).max() > 0.12


def test_weights_and_scale_are_found() -> None:
    """Weights within 5 of their standard errors; one of them is zero."""
    rng = np.random.default_rng(7)
    design = rng.standard_normal((200, 4))
    truth = np.array([0.0, 0.5, 1.0, 0.2])
    data = design @ truth + 0.3 * rng.standard_normal(200)
    error = 0.3 / math.sqrt(200)
    for draws in sample_weights(data, design, 199.0, np.array([truth, 2 * truth]), 1500, rng):
        assert (draws >= 0).all()
        np.testing.assert_allclose(draws.mean(axis=0)[1:], truth[1:], atol=5 * error)
        assert 0 < draws[:, 0].mean() < 5 * error
        assert draws[:, 2].std() == pytest.approx(error, rel=0.25)
