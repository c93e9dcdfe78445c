"""White noise is tested, and where it fails the likelihood widens by a named model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from hdprog.inference.noise_shape import (
    FALSE_ALARM_RATE,
    DecayingNoise,
    Shapes,
    _Restricted,
    fit_noise,
)
from tests.inference.inverse import decaying

BLOCKS = 150
POSITION = np.arange(float(BLOCKS))
SENSITIVITIES = np.vander(np.linspace(-1, 1, BLOCKS), 6)


def slow(rng: np.random.Generator, memory: float) -> np.ndarray:
    """Ornstein-Uhlenbeck noise (blocks,) of unit variance."""
    noise = np.empty(BLOCKS)
    noise[0] = rng.standard_normal()
    phi = np.exp(-1 / memory)
    for index in range(1, BLOCKS):
        noise[index] = phi * noise[index - 1] + np.sqrt(1 - phi**2) * rng.standard_normal()
    return noise


def residual(rng: np.random.Generator, share: float, memory: float) -> np.ndarray:
    """White plus Ornstein-Uhlenbeck noise of unit variance, what a fit absorbs taken out."""
    noise = np.sqrt(1 - share) * rng.standard_normal(BLOCKS) + np.sqrt(share) * slow(rng, memory)
    fitted = SENSITIVITIES @ np.linalg.lstsq(SENSITIVITIES, noise, rcond=None)[0]
    return 1e-5 * (noise - fitted)


def test_white_noise_stays_white_at_the_stated_rate() -> None:
    rng = np.random.default_rng(1)
    sd = np.full(BLOCKS, 1e-5)
    alarms = sum(
        fit_noise(residual(rng, 0.0, 1.0), SENSITIVITIES, sd, POSITION).whitening is not None
        for _ in range(200)
    )
    # One in a thousand that this fails by chance at the stated rate.
    assert alarms <= stats.binom.ppf(0.999, 200, FALSE_ALARM_RATE)


def test_shapes_that_are_left_out_have_no_weight(monkeypatch: pytest.MonkeyPatch) -> None:
    """Looked at from the best outwards the covariance is the whole grid's, to the last bit."""
    rng = np.random.default_rng(6)
    sd = 1e-5 * np.exp(0.3 * rng.standard_normal(BLOCKS))
    noises = [residual(rng, share, memory) for share, memory in ((0.3, 3.0), (0.6, 8.0), (0.9, 40))]
    outwards = [fit_noise(noise, SENSITIVITIES, sd, POSITION).covariance for noise in noises]
    looked_at = []

    def whole(
        _: np.ndarray, axes: tuple[np.ndarray, np.ndarray], seen: Callable[[np.ndarray], object]
    ) -> list[list[object]]:
        ratio, length = axes
        looked_at.append(ratio.size * length.size)
        return [[seen(np.array([one, other])) for one in ratio] for other in length]

    monkeypatch.setattr("hdprog.inference.noise_shape._seen_about", whole)
    for noise, found in zip(noises, outwards, strict=True):
        model = fit_noise(noise, SENSITIVITIES, sd, POSITION)
        assert np.array_equal(model.covariance, found)
    assert len(looked_at) == len(noises)


@pytest.mark.parametrize("rest", [0.0, 1e-9])
def test_a_residual_that_the_fit_explains_is_white(rest: float) -> None:
    """Records without noise, such as synthetic ones, leave nothing or next to nothing."""
    sd = np.full(BLOCKS, 1e-5)
    explained = SENSITIVITIES @ np.random.default_rng(3).standard_normal(SENSITIVITIES.shape[1])
    noise = explained + rest * np.random.default_rng(4).standard_normal(BLOCKS)
    for one in (noise, 0.0 * noise):
        assert fit_noise(one, SENSITIVITIES, sd, POSITION).whitening is None


def test_correlated_noise_is_found_and_whitened() -> None:
    rng = np.random.default_rng(2)
    sd = np.full(BLOCKS, 1e-5)
    found = 0
    for _ in range(20):
        noise = residual(rng, 0.6, 8.0)
        model = fit_noise(noise, SENSITIVITIES, sd, POSITION)
        if model.whitening is None:
            continue
        found += 1
        white = model.whiten(noise[None])[0]
        assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.3
        assert "Ornstein-Uhlenbeck" in model.words
    assert found >= 18


def test_whitening_undoes_a_covariance() -> None:
    distance = np.abs(POSITION[:, None] - POSITION[None, :])
    covariance = 1e-10 * (np.eye(BLOCKS) + 2 * np.exp(-distance / 5))
    model = decaying(np.full(BLOCKS, 1e-5), np.log(2), 5.0, POSITION)
    np.testing.assert_allclose(
        model.whitening.T @ covariance @ model.whitening, np.eye(BLOCKS), atol=1e-9
    )
    np.testing.assert_allclose(model.sd, np.sqrt(3e-10), rtol=1e-12)
    assert model.log_det == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-9)


@pytest.mark.parametrize("memory", [3.0, 10.0])
def test_intervals_allow_for_a_noise_shape_known_from_one_record(memory: float) -> None:
    """Generalised least squares with the noise found holds the truth as often as it says."""
    rng = np.random.default_rng(3)
    sd, inside = np.full(BLOCKS, 1e-5), []
    for _ in range(60):
        # The truth is zero: what least squares finds is all error.
        noise = 1e-5 * (
            np.sqrt(0.3) * rng.standard_normal(BLOCKS) + np.sqrt(0.7) * slow(rng, memory)
        )
        fitted = SENSITIVITIES @ np.linalg.lstsq(SENSITIVITIES, noise, rcond=None)[0]
        model = fit_noise(noise - fitted, SENSITIVITIES, sd, POSITION)
        design, observed = model.whiten(SENSITIVITIES.T), model.whiten(noise[None])[0]
        covariance = np.linalg.inv(design @ design.T)
        found = covariance @ (design @ observed)
        left = observed - found @ design
        scale = left @ left / (BLOCKS - len(found))
        inside.extend(np.abs(found) < 1.645 * np.sqrt(scale * np.diag(covariance)))
    # Six coefficients of a record hang together: some 150 independent ones of 360. With the shape
    # held at its best value the share is 0.82 to 0.84. A right one falls below this once in 100.
    assert np.mean(inside) > 0.85


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e4])
def test_banded_solution_is_the_dense_one(ratio: float) -> None:
    variance = 1e-10 * np.linspace(0.5, 2.0, BLOCKS)
    distance = np.abs(POSITION[:, None] - POSITION[None, :])
    dense = np.diag(variance) + 1e-10 * ratio * np.exp(-distance / 30)
    banded = DecayingNoise.of(variance, 1e-10 * ratio, np.diff(POSITION) / 30)
    columns = np.random.default_rng(0).standard_normal((BLOCKS, 3))
    wanted = np.linalg.solve(dense, columns)
    np.testing.assert_allclose(banded.solve(columns), wanted, atol=1e-8 * np.abs(wanted).max())
    assert banded.log_det == pytest.approx(np.linalg.slogdet(dense)[1], abs=1e-6)


def test_shapes_are_averaged_as_the_covariances_that_they_say() -> None:
    """Two shapes, as likely as each other, of which one says four times the variance."""
    position = np.array([0.0, 1.0, 3.0])
    ratio, length = np.log([0.5, 2.0]), np.log([1.0, 5.0])
    never = _Restricted(np.inf, 0.0)
    seen = [[_Restricted(7.0, 1.0), never], [never, _Restricted(7.0, 4.0)]]
    found = Shapes.of(np.zeros(2), (ratio, length), seen, 1.0, 1.0, 9.0).covariance(position)
    distance = np.abs(position[:, None] - position[None, :])
    first = 1.0 * (np.eye(3) + 0.5 * np.exp(-distance / 1.0))
    second = 4.0 * (np.eye(3) + 2.0 * np.exp(-distance / 5.0))
    mean, white = (first + second) / 2, (1.0 + 4.0) / 2
    np.testing.assert_allclose(np.eye(3) + found, mean / white, rtol=1e-12)
