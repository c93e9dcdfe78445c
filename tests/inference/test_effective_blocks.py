"""Blocks that the noise model leaves correlated count for fewer; those that it whitens do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.inference.effective_blocks import _long_run, effective_degrees
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.starting_points import StartingPoint, descend, describe
from tests.inference import remembering_loops
from tests.inference.inverse import decaying
from tests.inference.remembering_loops import READINGS, slow


def settled(seed: int) -> tuple[LoopLikelihood, StartingPoint]:
    """A loop with Ornstein-Uhlenbeck noise, fitted."""
    rng = np.random.default_rng([11, seed])
    remembered = slow(rng, kept=0.85, pushed=0.5)
    noise = 1e-5 * (2 * remembered + 0.2 * rng.standard_normal(READINGS))
    _, likelihood, starts = remembering_loops.settled(rng, noise)
    return likelihood, starts[0]


def test_rough_noise_that_is_whitened_keeps_its_blocks() -> None:
    shares = []
    for seed in range(12):
        likelihood, start = settled(seed)
        assert likelihood.noise.whitening is not None
        shares.append(effective_degrees(likelihood, start) / likelihood.degrees)
    # Tested at 1 %: two of twelve reject in 0.6 % of runs.
    assert sum(share < 1 for share in shares) <= 1


def test_noise_with_a_longer_memory_than_its_model_loses_blocks() -> None:
    likelihood, start = settled(0)
    reduced, sd = likelihood.reduced, np.full(likelihood.blocks, 1e-5)
    true = decaying(sd, np.log(4.0), 8.0, reduced.position).covariance
    wrong = replace(likelihood, noise=decaying(sd, np.log(4.0), 1.5, reduced.position))
    clean = likelihood.angle(start.point[None])[0]
    factor, rng = np.linalg.cholesky(true), np.random.default_rng(3)
    found, exact = [], []
    for _ in range(24):
        angle = clean + factor @ rng.standard_normal(likelihood.blocks)
        one = replace(wrong, reduced=replace(reduced, angle=angle))
        mode = descend(one, start.point)
        assert mode is not None
        found.append(one.degrees / effective_degrees(one, mode))
        # The same ratio from the covariance that the noise was drawn from.
        derivative = one.jacobian(mode.point)[1] * likelihood.prior_sd
        values, axes = np.linalg.eigh(derivative.T @ derivative)
        axes = axes[:, values > 4 * mode.variance]
        seen = np.linalg.qr(derivative @ axes)[0]
        left = one.noise.whitening.T @ true @ one.noise.whitening
        exact.append(np.trace(seen.T @ left @ seen) / axes.shape[1] / np.mean(np.diag(left)))
    # Scores sum to nothing at a mode and far lags are left out: about half is found, never more.
    assert np.mean(exact) > 3
    assert 0.35 * np.mean(exact) < np.mean(found) < np.mean(exact)


def test_fewer_blocks_widen_the_posterior_by_as_much() -> None:
    likelihood, start = settled(0)
    fewer = replace(likelihood, effective=likelihood.degrees / 4)
    points = np.stack([start.point, start.point + 1e-3])
    full, part = likelihood.log_likelihood(points), fewer.log_likelihood(points)
    assert part[1] - part[0] == pytest.approx((full[1] - full[0]) / 4, rel=1e-9)
    assert describe(fewer, start.point).variance == pytest.approx(4 * start.variance, rel=1e-9)
    scale = fewer.nuisances(np.repeat(points[:1], 4000, axis=0), np.random.default_rng(0))[1]
    # E[1/s²] is exact; its mean over 4000 draws scatters by 0.3 %.
    assert np.mean(scale**-2.0) * 4 * start.variance == pytest.approx(1.0, abs=0.012)


def test_lags_are_weighed_down_to_zero() -> None:
    """As sums over every window of four neighbours are, which hold a lag of l in 4 − l of them."""
    scores = np.random.default_rng(6).standard_normal((39, 2)).cumsum(axis=0)
    padded = np.vstack([np.zeros((3, 2)), scores, np.zeros((3, 2))])
    sums = np.array([padded[at : at + 4].sum(axis=0) for at in range(42)])
    np.testing.assert_allclose(_long_run(scores), sums.T @ sums / 4, rtol=1e-12)
