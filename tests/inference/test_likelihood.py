"""The likelihood: offset and scale integrated out, information form."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import dblquad

from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.information import information_form
from hdprog.inference.likelihood import HeldEffects, LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from tests.inference.inverse import coordinates_of, decaying
from tests.physics.table2 import POST_TEST

ALPHA = math.radians(30)
PRIOR = read_prior_file("csf-25-80").prior(None)
TRUTH = coordinates_of(PRIOR, POST_TEST)


def at(coordinates: np.ndarray) -> np.ndarray:
    """Points with the initial slip in the middle."""
    return np.hstack(
        [np.atleast_2d(coordinates), np.zeros((np.atleast_2d(coordinates).shape[0], 1))]
    )


def likelihood(noise: float, samples: int = 121, offset: float = 0.0) -> LoopLikelihood:
    rng = np.random.default_rng(9)
    quarter = np.linspace(0, 63, samples // 4 + 1)
    torque = np.concatenate([quarter, quarter[-2::-1], -quarter[1:], -quarter[-2::-1]])
    angle = predict(torque, POST_TEST) + offset + noise * rng.standard_normal(torque.size)
    loop = Loop(torque=torque, angle=angle)
    reduced = reduce_loop(loop, turning_points(torque), 0.0)
    return LoopLikelihood(reduced, PRIOR, ALPHA, NoiseModel.white(np.full(torque.size, 1e-5)))


def test_integrating_out_offset_and_scale_by_hand_gives_the_same() -> None:
    model = likelihood(1e-5, samples=13)
    points = [TRUTH + shift for shift in (0.0, 0.01, -0.02)]
    fast = np.array([model.log_likelihood(at(point))[0] for point in points])

    def slow(point: np.ndarray) -> float:
        missing = (model.reduced.angle - model.angle(at(point))[0]) / 1e-5

        def density(offset: float, log_s: float) -> float:
            s = math.exp(log_s)  # prior 1/s² on s² is flat in log s
            squares = ((missing - offset) ** 2).sum() / s**2
            return math.exp(-0.5 * squares + 30.0) / s**missing.size

        centre = float(missing.mean())
        return math.log(dblquad(density, -4, 4, centre - 15, centre + 15)[0])

    by_hand = np.array([slow(point) for point in points])
    np.testing.assert_allclose(fast - fast[0], by_hand - by_hand[0], atol=1e-3)


def test_offset_does_not_matter_and_is_found() -> None:
    plain, shifted = likelihood(1e-5), likelihood(1e-5, offset=0.02)
    points = at(np.tile(TRUTH, (400, 1)))
    first = plain.log_likelihood(points[:1])
    assert shifted.log_likelihood(points[:1]) == pytest.approx(first, abs=1e-6)
    offset, scale = shifted.nuisances(points, np.random.default_rng(1))
    # 400 draws: 5 standard errors of their means.
    assert offset.mean() == pytest.approx(0.02, abs=5e-6)
    assert scale.mean() == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("memory", [0.0, 6.0])
def test_effects_integrated_out_are_a_covariance(memory: float) -> None:
    """The likelihood with held effects against the Gaussian with their covariance written out."""
    rng = np.random.default_rng(4)
    plain = likelihood(1e-5)
    noise = plain.noise
    if memory:
        noise = decaying(noise.sd, 0.5, memory, np.arange(float(plain.blocks)))
    exact = replace(plain, noise=noise, effects=(BY_ID["cup_hardening"], BY_ID["angle_ripple"]))
    size = exact.effect_set.size
    features = 3e-5 * rng.standard_normal((plain.blocks, size))
    held = HeldEffects(0.1 * rng.standard_normal(size), np.zeros(plain.blocks), features)
    found = replace(exact, held=held)
    covariance = noise.covariance + features @ features.T
    points = at(TRUTH + 0.01 * rng.standard_normal((5, 8)))
    left = found.reduced.angle - found.angle(points)
    inverse = np.linalg.inv(covariance)
    pull = inverse.sum(axis=0)
    squares = np.einsum("di,ij,dj->d", left, inverse, left) - (left @ pull) ** 2 / pull.sum()
    wanted = -0.5 * (found.blocks - 1) * np.log(squares)
    np.testing.assert_allclose(found.log_likelihood(points), wanted, rtol=1e-9)
    assert found.offset(left[0]) == pytest.approx(left[0] @ pull / pull.sum(), rel=1e-9)


def test_information_form_is_the_likelihood_near_its_point() -> None:
    """Against the exact log-likelihood at fixed noise, along every coordinate."""
    model = likelihood(1e-5, samples=241)
    point = np.append(TRUTH, 0.0)
    linear = information_form(*model.jacobian(point), TRUTH, point, np.arange(8), variance=1.0)
    assert np.linalg.eigvalsh(linear.precision).min() > -1e-6
    sd = 1 / np.sqrt(np.diag(linear.precision))

    def exact(point: np.ndarray) -> float:
        residual = model.residual(at(point))[0]
        return float(-0.5 * residual @ residual)

    def quadratic(point: np.ndarray) -> float:
        return float(linear.information @ point - 0.5 * point @ linear.precision @ point)

    for index in range(8):
        step = 0.3 * sd[index] * np.eye(8)[index]
        found = quadratic(TRUTH + step) - quadratic(TRUTH - step)
        wanted = exact(TRUTH + step) - exact(TRUTH - step)
        assert found == pytest.approx(wanted, abs=0.05)


def test_log_density_of_blocks_adds_up() -> None:
    model = likelihood(1e-5)
    one = np.array([1.0])
    pointwise = model.pointwise(at(TRUTH), 0 * one, one)[0]
    missing = model.reduced.angle - model.angle(at(TRUTH))[0]
    wanted = -0.5 * (missing / 1e-5) ** 2 - np.log(1e-5 * np.sqrt(2 * np.pi))
    np.testing.assert_allclose(pointwise, wanted, rtol=1e-9)


def test_nuisances_are_integrated_out_with_their_own_priors() -> None:
    """The slope and the curvature of the complete log density by finite differences, reduced.

    The logit of the initial slip is logistic a priori, effects are standard normal; the data
    say as much of all of them as their priors do.
    """
    rng = np.random.default_rng(8)
    point = rng.standard_normal(11)
    derivative, residual = 0.4 * rng.standard_normal((30, 11)), rng.standard_normal(30)
    found = information_form(residual, derivative, point[:8], point, np.arange(8), variance=1.7)

    def log_density(at: np.ndarray) -> float:
        left = residual + derivative @ (at - point)
        prior = stats.logistic.logpdf(at[8]) + stats.norm.logpdf(at[9:]).sum()
        return float(-0.5 * left @ left / 1.7 + prior)

    step = 1e-3 * np.eye(11)
    slope = np.array([log_density(point + d) - log_density(point - d) for d in step]) / 2e-3
    curvature = [
        [
            log_density(point + d + e)
            - log_density(point + d - e)
            - log_density(point - d + e)
            + log_density(point - d - e)
            for d in step
        ]
        for e in step
    ]
    curvature = -np.array(curvature) / 4e-6
    covariance = np.linalg.inv(curvature)
    # What the Gaussian of all says of the state alone.
    precision = np.linalg.inv(covariance[:8, :8])
    moved = (covariance @ slope)[:8]
    np.testing.assert_allclose(found.precision, precision, atol=1e-4 * np.abs(precision).max())
    wanted = precision @ (point[:8] + moved)
    np.testing.assert_allclose(found.information, wanted, atol=1e-4 * np.abs(wanted).max())
