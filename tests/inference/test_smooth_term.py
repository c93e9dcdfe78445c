"""The empirical term is the Gaussian process that it says, and blocks can be masked."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.smooth_term import LENGTHS, SmoothTerm, basis_of, spectrum
from hdprog.physics.course import Course
from hdprog.physics.drive_model import predict
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath
from tests.inference.inverse import coordinates_of, decaying
from tests.physics.table2 import POST_TEST

PRIOR = read_prior_file("csf-25-80").prior(None)


def timed_loop(samples: int = 161) -> Loop:
    time = np.linspace(0.0, 100.0, samples)
    torque = np.interp(time, [0, 20, 60, 100], [0, 80, -80, 80])
    rng = np.random.default_rng(6)
    return Loop(torque, predict(torque, POST_TEST) + 1e-5 * rng.standard_normal(samples), time)


LOOP = timed_loop()
COURSE: Course = record_course(LOOP, TorquePath.exact(LOOP.torque), 0.0)


def term(coordinate: str, length: float, sd: float = 1.0) -> SmoothTerm:
    values = {"time": LOOP.time, "torque": LOOP.torque, "branch": LOOP.torque}[coordinate]
    assert values is not None
    return SmoothTerm(coordinate, float(values.min()), float(values.max()), sd * spectrum(length))


def structure(covariance: FloatArray) -> FloatArray:
    """Variance of differences, which no constant enters."""
    own = np.diag(covariance)
    return np.asarray(own[:, None] + own[None, :] - 2 * covariance)


@pytest.mark.parametrize("length", LENGTHS)
def test_covariance_is_that_of_a_matern_process(length: float) -> None:
    """Of order 3/2, up to its constant, which is the offset's.

    The size is that of the process without its constant: more than 1 where that carries much.
    """
    features = term("time", length).features(COURSE)
    distance = 0.9 * np.abs(COURSE.order[:, None] - COURSE.order[None, :]) / length
    matern = (1 + math.sqrt(3) * distance) * np.exp(-math.sqrt(3) * distance)
    # Within the middle half: cosines have a level tangent at the ends.
    inside = slice(40, 121)
    found = structure(features @ features.T)[inside, inside]
    wanted = structure(matern)[inside, inside]
    far = distance[inside, inside] > 0.5
    ratio = (found / np.where(far, wanted, 1.0))[far]
    assert ratio.max() / ratio.min() < 1.25
    assert 0.95 < np.median(ratio) < {0.3: 1.7, 0.1: 1.2, 0.035: 1.08, 0.015: 1.05}[length]
    assert np.sum(spectrum(length) ** 2) == pytest.approx(1.0)


def test_size_and_range_scale_the_term() -> None:
    plain, large = term("time", 0.1).features(COURSE), term("time", 0.1, 3e-5).features(COURSE)
    np.testing.assert_allclose(large, 3e-5 * plain, rtol=1e-12)
    beyond = replace(term("time", 0.1), low=20.0, high=60.0).features(COURSE)
    assert LOOP.time is not None
    # Outside its range a term stays as it is at the end.
    np.testing.assert_array_equal(
        beyond[LOOP.time <= 20], beyond[LOOP.time <= 20][:1].repeat(33, 0)
    )


def test_branches_have_a_function_each_and_others_turn_round() -> None:
    features = term("branch", 0.1).features(COURSE)
    covariance = features @ features.T
    rising = COURSE.path.direction > 0
    assert np.abs(covariance[np.ix_(rising, ~rising)]).max() == 0.0
    both = term("torque", 0.1).features(COURSE)
    same = (both @ both.T)[np.ix_(rising, rising)]
    np.testing.assert_allclose(covariance[np.ix_(rising, rising)], same, rtol=1e-9, atol=1e-12)
    for name in ("distance_since_reversal", "time_since_reversal"):
        basis = basis_of(name, 0.0, 160.0, COURSE)
        # 70 Nm or 17.5 s behind the reversal, falling (35 readings on) and rising.
        np.testing.assert_allclose(basis[32 + 28], -basis[96 + 28], atol=1e-9)


def masked_cases() -> list[tuple[str, NoiseModel]]:
    sd = 1e-5 * np.linspace(0.8, 1.3, len(LOOP))
    white = NoiseModel.white(sd)
    position = np.arange(float(len(LOOP)))
    remembering = decaying(sd, 0.5, 6.0, position)
    smooth = term("time", 0.1, 3e-5)
    return [
        ("white", white),
        ("decaying", remembering),
        ("white beside a term", white.with_term(smooth, COURSE)),
        ("decaying beside a term", remembering.with_term(smooth, COURSE)),
    ]


OUT: NDArray[np.bool_] = (np.arange(len(LOOP)) % 50 > 35) | (np.arange(len(LOOP)) == 3)


def likelihood_with(noise: NoiseModel) -> LoopLikelihood:
    reduced = reduce_loop(LOOP, turning_points(LOOP.torque), 0.0)
    return LoopLikelihood(reduced, PRIOR, math.radians(30), noise)


@pytest.mark.parametrize(("words", "noise"), masked_cases(), ids=lambda value: str(value)[:24])
def test_masked_blocks_are_as_if_not_there(words: str, noise: NoiseModel) -> None:
    """The misfit is that of the other blocks under their own covariance, offset integrated out."""
    masked = likelihood_with(noise.masking(OUT))
    rng = np.random.default_rng(8)
    truth = coordinates_of(PRIOR, POST_TEST)
    points = np.append(truth, 0.0) + 0.02 * rng.standard_normal((4, 9))
    residual = masked.residual(points)
    seen = ~OUT
    covariance = noise.covariance[np.ix_(seen, seen)]
    missing = (masked.reduced.angle - masked.angle(points))[:, seen]
    ones = np.ones(int(seen.sum()))
    solved, solved_ones = np.linalg.solve(covariance, missing.T), np.linalg.solve(covariance, ones)
    wanted = np.einsum("ij,ji->i", missing, solved)
    wanted -= (missing @ solved_ones) ** 2 / (ones @ solved_ones)
    np.testing.assert_allclose(np.sum(residual**2, axis=1), wanted, rtol=1e-5)
    # What was measured there does not count.
    elsewhere = replace(masked.reduced, angle=masked.reduced.angle + 1e-4 * OUT)
    moved = replace(masked, reduced=elsewhere)
    np.testing.assert_allclose(
        moved.log_likelihood(points), masked.log_likelihood(points), atol=1e-3
    )


def test_masking_nothing_changes_nothing() -> None:
    for _, noise in masked_cases():
        same = noise.masking(np.zeros(len(LOOP), dtype=bool))
        np.testing.assert_allclose(same.covariance, noise.covariance, rtol=1e-9, atol=1e-24)


def test_the_smooth_part_is_the_conditional_mean() -> None:
    """Of the blocks left out as well, from those that were seen."""
    smooth = term("time", 0.1, 3e-5)
    sd = np.full(len(LOOP), 1e-5)
    noise = NoiseModel.white(sd).with_term(smooth, COURSE)
    features = smooth.features(COURSE)
    prior = features @ features.T
    residual = 1e-5 * np.random.default_rng(9).standard_normal(len(LOOP))
    wanted = prior @ np.linalg.solve(prior + np.diag(sd**2), residual)
    np.testing.assert_allclose(noise.smooth_part(residual), wanted, rtol=1e-6, atol=1e-12)
    seen = ~OUT
    inner = prior[np.ix_(seen, seen)] + np.diag(sd[seen] ** 2)
    wanted = prior[:, seen] @ np.linalg.solve(inner, residual[seen])
    found = features @ noise.masking(OUT).coefficients(residual)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10)
    assert noise.as_white.smooth_part(residual).tolist() == [0.0] * len(LOOP)
    np.testing.assert_array_equal(noise.as_white.sd, sd)


def test_the_noise_about_a_fitted_curve_is_without_the_curve() -> None:
    noise = NoiseModel.white(np.full(len(LOOP), 1e-5))
    wider = noise.with_term(term("torque", 0.1, 4e-4), COURSE)
    assert wider.sd.min() > 1e-4
    np.testing.assert_allclose(wider.scatter, noise.sd, rtol=1e-6)
