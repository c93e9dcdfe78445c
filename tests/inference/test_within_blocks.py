"""Readings inside blocks tell the noise scale where it is the blocks', and only there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.reduce import ReducedLoop, reduce_loop
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.posterior import Posterior
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.sampling_plan import QUICK
from hdprog.inference.within_blocks import FALSE_ALARM_RATE, WithinBlocks
from tests.independent.loops import random_loop
from tests.independent.simulator import MeasurementChain

READINGS, TURN = 1200, 600
SLOPE, TORQUE_NOISE, ANGLE_NOISE = 2e-5, 0.05, 8e-6


def reduced_line(rng: np.random.Generator) -> tuple[Loop, ReducedLoop]:
    """A straight spring wound up and down, torque and angle with white noise, in blocks."""
    torque = np.interp(np.arange(READINGS), [0, TURN, READINGS - 1], [-80.0, 80.0, -80.0])
    angle = SLOPE * torque + ANGLE_NOISE * rng.standard_normal(READINGS)
    loop = Loop(torque=torque + TORQUE_NOISE * rng.standard_normal(READINGS), angle=angle)
    points = np.array([0, TURN, READINGS - 1], dtype=np.intp)
    return loop, reduce_loop(loop, points, TORQUE_NOISE, max_blocks=200)


def within(loop: Loop, reduced: ReducedLoop) -> WithinBlocks:
    blocks = reduced.count.size
    sd = np.hypot(ANGLE_NOISE, SLOPE * TORQUE_NOISE)
    return WithinBlocks.of(loop, reduced, np.full(blocks, SLOPE), np.full(blocks, sd))


def test_scatter_inside_blocks_follows_chi_square_where_noise_is_white() -> None:
    rng = np.random.default_rng(4)
    found = [within(*reduced_line(rng)) for _ in range(300)]
    degrees = found[0].degrees
    assert 700 < degrees < READINGS - 200
    scaled = np.array([(one.squares - one.degrees) / np.sqrt(2 * one.degrees) for one in found])
    # Mean and standard deviation of 300 draws: four standard errors each, wrong once in 10 000.
    assert abs(scaled.mean()) < 4 / np.sqrt(300)
    assert abs(scaled.std() - 1) < 4 / np.sqrt(600)


def test_readings_set_aside_say_nothing() -> None:
    loop, _ = reduced_line(np.random.default_rng(5))
    kept = np.ones(READINGS, dtype=bool)
    kept[100:140:4] = False
    angle = loop.angle.copy()
    angle[~kept] += 1.0
    points = np.array([0, TURN, READINGS - 1], dtype=np.intp)
    spoilt = replace(loop, angle=angle)
    found = within(spoilt, reduce_loop(spoilt, points, TORQUE_NOISE, kept, max_blocks=200))
    assert found.squares < 1.3 * found.degrees


def test_blocks_with_the_same_noise_disagree_as_often_as_said() -> None:
    rng = np.random.default_rng(6)
    count, blocks, readings = 4000, 380, 1700
    inside = rng.chisquare(readings, count)
    squares = rng.chisquare(blocks, count)
    alarms = [
        not WithinBlocks(float(one), readings).agrees(float(other), blocks)
        for one, other in zip(inside, squares, strict=True)
    ]
    # 40 expected of 4000, give or take 6.3; four standard deviations.
    assert abs(np.mean(alarms) - FALSE_ALARM_RATE) < 4 * np.sqrt(FALSE_ALARM_RATE / count)


def test_blocks_that_scatter_more_or_less_than_their_readings_disagree() -> None:
    inside = WithinBlocks(1700.0, 1700.0)
    assert inside.agrees(380.0, 380.0)
    assert not inside.agrees(1.3 * 380.0, 380.0)
    assert not inside.agrees(0.7 * 380.0, 380.0)
    assert not inside.agrees(0.0, 0.0)
    # A simulated record without noise, or one that stands still.
    assert not WithinBlocks(0.0, 1700.0).agrees(380.0, 380.0)
    assert not WithinBlocks(0.0, 0.0).agrees(380.0, 380.0)


def fitted(correlation_time: float, samples: int) -> Posterior:
    """A long record of the independent simulator, its noise white or with a memory."""
    rng = np.random.default_rng(18)
    chain = MeasurementChain(
        torque_noise=0.04,
        angle_noise=1e-5,
        correlation_time=correlation_time,
        correlated_share=0.5 if correlation_time else 0.0,
    )
    record = random_loop(rng, "two-sided", samples=samples, chain=chain)
    loop = Loop(torque=record.torque, angle=record.angle, time=record.time)
    drive = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
    return fit_loop(loop, drive, rng, prior=read_prior_file("csf-25-80").prior(None), plan=QUICK)


def spread_of_scale(posterior: Posterior) -> float:
    return float(posterior.noise_scale.std() / posterior.noise_scale.mean())


def test_a_long_record_knows_its_noise_by_all_readings() -> None:
    posterior = fitted(0.0, 4000)
    likelihood = posterior.likelihood
    assert likelihood.within is not None
    # A scale known by n degrees of freedom has the relative spread 1/√(2n).
    assert spread_of_scale(posterior) < 1.2 / np.sqrt(2 * 3500)
    assert likelihood.widening == 1.0
    assert posterior.sampling["effective_blocks"] == likelihood.blocks


def test_readings_tell_the_scale_of_noise_with_a_memory() -> None:
    correlated = fitted(10.0, 4000)
    assert correlated.likelihood.noise.whitening is not None
    assert correlated.likelihood.within is not None
    # Of some 2 000 finer blocks: their noise is the white part.
    assert spread_of_scale(correlated) < 1.2 / np.sqrt(2 * 1900)


def test_short_records_are_left_to_their_blocks() -> None:
    assert fitted(0.0, 280).likelihood.within is None
