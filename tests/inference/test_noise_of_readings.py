"""Readings inside blocks tell how noise remembers, where the blocks do not say otherwise."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.noise_of_readings import with_noise_of_readings
from hdprog.inference.noise_shape import Shapes, fit_shapes
from hdprog.inference.prepare import Prepared, prepare, settle_noise
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.within_blocks import FALSE_ALARM_RATE, WithinBlocks
from tests.independent.loops import random_loop
from tests.independent.simulator import MeasurementChain

SHAPES = Shapes(2.0, 3.0, np.array([2.0, 0.5, 0.1]), np.array([3.0, 40.0, 0.2]), 1.0, 1.0)


def test_a_block_has_the_covariance_of_its_mean() -> None:
    """Uneven steps, uneven blocks, gaps where readings were set aside, one block of one reading."""
    rng = np.random.default_rng(1)
    block_of = np.repeat(np.arange(7), [1, 9, 4, 30, 2, 2, 12])
    position = np.cumsum(rng.exponential(size=block_of.size) + 1e-3)
    position[12:] += 25.0
    averaging = (block_of == np.arange(7)[:, None]) / np.bincount(block_of)[:, None]
    expected = averaging @ SHAPES.covariance(position) @ averaging.T
    np.testing.assert_allclose(
        SHAPES.covariance_of_means(position, block_of), expected, rtol=1e-12, atol=1e-14
    )


def test_blocks_of_one_reading_have_the_covariance_of_readings() -> None:
    position = np.array([0.0, 1.0, 1.5, 400.0])
    np.testing.assert_allclose(
        SHAPES.covariance_of_means(position, np.arange(4)),
        SHAPES.covariance(position),
        rtol=1e-12,
        atol=1e-14,
    )


def remembering(rng: np.random.Generator, count: int, share: float, memory: float) -> np.ndarray:
    """(count,) white and Ornstein-Uhlenbeck noise of unit variance together."""
    kept = np.exp(-1 / memory)
    slow = np.empty(count)
    slow[0] = rng.standard_normal()
    pushed = np.sqrt(1 - kept**2) * rng.standard_normal(count)
    for at in range(1, count):
        slow[at] = kept * slow[at - 1] + pushed[at]
    return np.sqrt(1 - share) * rng.standard_normal(count) + np.sqrt(share) * slow


def test_the_scale_is_that_of_the_white_part_and_disagreement_as_rare_as_said() -> None:
    """Blocks of three readings beside a straight line, as often as a record of 450 is drawn."""
    rng = np.random.default_rng(2)
    count, draws, sd, white_sd = 450, 120, 3e-6, 2e-6
    block_of = np.arange(count) // 3
    position = np.arange(float(count))
    blocks = position.reshape(-1, 3).mean(axis=1)
    line = np.vander(np.linspace(-1, 1, count), 4)
    line_of_blocks = line.reshape(-1, 3, 4).mean(axis=1)
    scale, alarms = [], 0
    for _ in range(draws):
        noise = sd * remembering(rng, count, 0.5, 12.0)
        left = noise - line @ np.linalg.lstsq(line, noise, rcond=None)[0]
        shapes = fit_shapes(left, line, np.full(count, white_sd), position)
        assert shapes is not None
        assert shapes.degrees == count - 4
        scale.append(np.sqrt(shapes.squares / shapes.degrees))
        covariance = shapes.covariance_of_means(position, block_of)
        covariance += white_sd**2 / 3 * np.eye(blocks.size)
        factor = np.linalg.cholesky(covariance)
        both = np.linalg.solve(
            factor, np.column_stack([line_of_blocks, noise.reshape(-1, 3).mean(axis=1)])
        )
        rest = both[:, 4] - both[:, :4] @ np.linalg.lstsq(both[:, :4], both[:, 4], rcond=None)[0]
        squares, degrees = float(rest @ rest), blocks.size - 4
        within = WithinBlocks(shapes.squares - squares, shapes.degrees - degrees)
        alarms += not within.agrees(squares, degrees)
    # Standard error of the mean of 120 scales, each known to about 6 %: 0.6 %; five of them.
    assert np.mean(scale) == pytest.approx(sd * np.sqrt(0.5) / white_sd, rel=0.03)
    # One in a thousand that this fails by chance at the stated rate.
    assert alarms <= stats.binom.ppf(0.999, draws, FALSE_ALARM_RATE)


@cache
def prepared(hum: float) -> Prepared:
    """A record whose noise has a memory, beside a hum (rad) that blocks average away."""
    rng = np.random.default_rng(18)
    chain = MeasurementChain(
        torque_noise=0.04, angle_noise=1e-5, correlation_time=10.0, correlated_share=0.5
    )
    record = random_loop(rng, "two-sided", samples=1800, chain=chain)
    angle = record.angle + hum * np.cos(np.pi * np.arange(record.angle.size))
    loop = Loop(torque=record.torque, angle=angle, time=record.time)
    drive = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
    return prepare(loop, drive, rng, prior=read_prior_file("csf-25-80").prior(None))


def test_readings_tell_the_noise_of_blocks() -> None:
    one = prepared(0.0)
    likelihood, starts = settle_noise(one.likelihood, one.starts, np.random.default_rng(1))
    assert likelihood.noise.log_ratio is not None
    told, again, within = with_noise_of_readings(one, likelihood, starts)
    assert within is not None
    assert within.degrees > 3 * told.block_degrees
    assert told.noise.correlation_length is not None
    # The noise remembers for 10 s of the record's 32: so few lengths tell it within a factor.
    assert 1.0 < told.noise.correlation_length < 100.0
    assert [start.deviance for start in again] == sorted(start.deviance for start in again)


def test_blocks_stand_where_their_readings_say_otherwise() -> None:
    one = prepared(2e-5)
    likelihood, starts = settle_noise(one.likelihood, one.starts, np.random.default_rng(1))
    assert likelihood.noise.log_ratio is not None
    told, again, within = with_noise_of_readings(one, likelihood, starts)
    assert told is likelihood
    assert again is starts
    assert within is None


def test_white_noise_is_left_as_it_is() -> None:
    one = prepared(0.0)
    told, starts, within = with_noise_of_readings(one, one.likelihood, one.starts)
    assert (told, starts, within) == (one.likelihood, one.starts, None)
