"""Long records reduced along the path, short ones left alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from hdprog.data.loop import Loop
from hdprog.data.reduce import ReducedLoop, enough_blocks, reduce_loop
from hdprog.data.turning_points import turning_points
from tests.data.samples import FloatArray, ramps

PEAK, NOISE = 63.0, 0.05


@dataclass(frozen=True)
class Record:
    loop: Loop
    true_torque: FloatArray
    points: np.ndarray
    reduced: ReducedLoop


def held_triangle(samples: int = 35_000) -> FloatArray:
    """Two cycles, with holds of a twentieth of the record at mid-load and at two reversals."""
    knots = [(0, 0), (4, 40), (5, 40), (7, PEAK), (8, PEAK), (14, -PEAK), (15, -PEAK)]
    knots += [(21, PEAK), (27, -PEAK), (30, 0)]
    at, torque = np.array(knots, dtype=float).T
    return np.interp(np.linspace(0, at[-1], samples), at, torque)


@pytest.fixture(name="record", scope="module")
def record_fixture() -> Record:
    rng = np.random.default_rng(4)
    truth = held_triangle()
    torque = truth + NOISE * rng.standard_normal(truth.size)
    angle = truth / 2e4 + 1e-5 * rng.standard_normal(truth.size)
    loop = Loop(torque=torque, angle=angle, time=np.arange(truth.size) * 0.01)
    points = turning_points(torque)
    return Record(loop, truth, points, reduce_loop(loop, points, NOISE))


def test_a_short_record_is_untouched() -> None:
    torque = ramps(0, 40, -40, 40, 0, samples=51)
    loop = Loop(torque=torque, angle=torque / 2e4, time=np.arange(torque.size) * 0.5)
    reduced = reduce_loop(loop, turning_points(torque), 0.0)
    np.testing.assert_array_equal(reduced.path.torque, torque)
    np.testing.assert_array_equal(reduced.angle, loop.angle)
    np.testing.assert_array_equal(reduced.count, 1)
    np.testing.assert_array_equal(reduced.position, np.arange(torque.size))
    np.testing.assert_array_equal(reduced.time, loop.time)
    np.testing.assert_array_equal(reduced.block_of, np.arange(torque.size))
    assert reduced.path.variance is None
    # A stretch starts behind the reading at the reversal.
    assert reduced.path.starts.tolist() == [0, 51, 101, 151]
    assert reduced.path.rising.tolist() == [True, False, True, False]
    assert reduced.path.reversal_torque is not None
    np.testing.assert_allclose(reduced.path.reversal_torque, [40, -40, 40, 0])


def test_the_number_of_blocks_is_bounded(record: Record) -> None:
    assert 250 <= record.reduced.angle.size <= 330
    assert len(record.points) == 6  # four reversals and the two ends


@pytest.mark.parametrize("aim", [60, 300, 900])
def test_the_aim_is_met_whatever_it_is(record: Record, aim: int) -> None:
    blocks = reduce_loop(record.loop, record.points, NOISE, max_blocks=aim).angle.size
    assert 0.8 * aim <= blocks <= 1.1 * aim


def wanted(*corners: float, samples: int = 300) -> int:
    torque = ramps(*corners, samples=samples)
    return enough_blocks(torque, turning_points(torque))


def test_cycles_and_readings_have_blocks_of_their_own_up_to_a_bound() -> None:
    cycle = (0, 40, -40, 40, 0)
    assert wanted(*cycle) == wanted(*cycle, samples=700) == 400
    assert wanted(*cycle, *cycle[1:], *cycle[1:]) == pytest.approx(1170, abs=10)
    assert wanted(*cycle, *(cycle[1:] * 9)) == wanted(*cycle, *(cycle[1:] * 4)) == 1200
    # A one-sided record crosses its whole range with each ramp.
    assert wanted(0, 40, 0, 40, 0, 40, 0, 40, 0) == 1040
    assert 400 < wanted(*cycle, samples=1500) < wanted(*cycle, samples=8_000) == 800
    # A short record is not kept reading by reading for it.
    assert wanted(0, 40, 0, 40, 0, samples=200) == 400 < wanted(0, 40, 0, 40, 0) == 520
    # Small loops travel little, yet each has its corners.
    assert wanted(0, 40, -40, 40, 38, 40, 38, 40, 38, 40, 38, 40) == 600


def test_no_block_crosses_a_reversal(record: Record) -> None:
    block_of = record.reduced.block_of
    assert (np.diff(block_of) >= 0).all()
    for turn in record.points[1:-1]:
        assert block_of[turn + 1] == block_of[turn] + 1
    firsts = block_of[np.concatenate([[0], record.points[1:-1] + 1])]
    np.testing.assert_array_equal(record.reduced.path.starts, firsts)
    assert record.reduced.path.rising.tolist() == [True, False, True, False, True]


def test_nothing_is_lost_in_the_means(record: Record) -> None:
    reduced, loop = record.reduced, record.loop
    assert reduced.count.sum() == len(loop)
    assert reduced.time is not None
    for means, values in (
        (reduced.angle, loop.angle),
        (reduced.path.torque, loop.torque),
        (reduced.position, np.arange(len(loop))),
        (reduced.time, loop.time),
    ):
        assert np.average(means, weights=reduced.count) == pytest.approx(np.mean(values), rel=1e-9)
    some = reduced.block_of == 100
    assert reduced.angle[100] == pytest.approx(loop.angle[some].mean(), rel=1e-12)


def test_reversals_are_denoised(record: Record) -> None:
    found = record.reduced.path.reversal_torque
    assert found is not None
    truth = np.array([PEAK, -PEAK, PEAK, -PEAK, 0])
    # The extreme of 35 000 noisy readings lies four noise standard deviations out. Behind a mean
    # over w readings three of noise/√w are left; a mean over the tip of a triangle of slope s
    # falls short by s·w/4, which the window holds to about the same.
    slope = np.abs(np.diff(record.true_torque)).max()
    window = (4 * NOISE / slope) ** (2 / 3)
    error = np.abs(found - truth)
    assert (error[:-1] < 3 * NOISE / np.sqrt(window) + slope * window / 4).all()
    at_extremes = np.abs(record.loop.torque[record.points[1:-1]] - truth[:-1])
    assert error[:-1].mean() < at_extremes.mean() / 2
    # The record ends on its last reading: half a window on one side is all there is.
    assert error[-1] < 3 * NOISE / np.sqrt(window / 2) + slope * window / 2


def test_variance_inside_a_block_is_that_of_a_ramp(record: Record) -> None:
    variance = record.reduced.path.variance
    assert variance is not None
    blocks = variance.size
    ratios = []
    for block in range(blocks):
        truth = record.true_torque[record.reduced.block_of == block]
        expected = np.ptp(truth) ** 2 / 12
        steady = np.allclose(np.diff(truth), np.diff(truth)[:1]) and truth.size > 20
        if steady and expected > 10 * NOISE**2:
            ratios.append(variance[block] / expected)
    assert len(ratios) > 50
    # What noise leaves of it: 2·noise/√(n·travel²/12), a few per cent in a block.
    assert np.mean(ratios) == pytest.approx(1, abs=0.02)
    assert np.std(ratios) < 0.1


def test_variance_at_a_hold_is_none(record: Record) -> None:
    variance, block_of = record.reduced.path.variance, record.reduced.block_of
    assert variance is not None
    held = [
        block
        for block in range(variance.size)
        if np.ptp(record.true_torque[block_of == block]) == 0.0
    ]
    # Holds have blocks of their own, so that what creeps at a hold can be seen.
    assert len(held) >= 6
    # The noise of a block's readings is taken off; of its variance about √(2/n) is left.
    assert variance[held].mean() < 0.2 * NOISE**2


def test_readings_set_aside_are_out(record: Record) -> None:
    rng = np.random.default_rng(7)
    kept = rng.random(len(record.loop)) > 0.05
    kept[record.reduced.block_of == 50] = False  # a whole block goes
    angle = np.where(kept, record.loop.angle, 1e3)
    loop = Loop(torque=record.loop.torque, angle=angle)
    reduced = reduce_loop(loop, record.points, NOISE, kept)
    assert reduced.angle.size == record.reduced.angle.size - 1
    assert np.abs(reduced.angle).max() < 0.01
    assert reduced.count.sum() == kept.sum()
    assert reduced.count.min() > 0
    assert (reduced.block_of[~kept] == -1).all()
    assert (np.unique(reduced.block_of[kept]) == np.arange(reduced.angle.size)).all()
    mean = np.average(reduced.angle, weights=reduced.count)
    assert mean == pytest.approx(angle[kept].mean(), rel=1e-9)
    assert reduced.time is None
    # The stretches stay where they were: the lost block lies on the first of them.
    moved = np.where(record.reduced.path.starts > 50, 1, 0)
    np.testing.assert_array_equal(reduced.path.starts, record.reduced.path.starts - moved)


def test_readings_of_a_short_record_set_aside_are_out() -> None:
    torque = ramps(0, 40, -40, 0, samples=21)
    kept = np.ones(torque.size, dtype=bool)
    kept[[5, 20, 21]] = False  # the reversal itself among them
    loop = Loop(torque=torque, angle=torque / 2e4)
    reduced = reduce_loop(loop, turning_points(torque), 0.0, kept)
    np.testing.assert_array_equal(reduced.path.torque, torque[kept])
    assert reduced.path.starts.tolist() == [0, 19, 38]
    assert reduced.path.reversal_torque is not None
    assert reduced.path.reversal_torque[0] == pytest.approx(40)


@pytest.mark.parametrize(
    "torque",
    [
        [92.0, 96.0, *np.linspace(100.0, 0.0, 26), *np.linspace(4.0, 100.0, 25)],
        [96.0, *np.linspace(100.0, -100.0, 26), *np.linspace(-92.0, 100.0, 25)],
        [*np.linspace(0.0, 100.0, 26), *np.linspace(96.0, 0.0, 25), 5.0, 10.0],
        [*np.linspace(0.0, 100.0, 26), 95.0, 90.0, 95.0, *np.linspace(100.0, 0.0, 26)],
    ],
    ids=["begins before the top", "begins a reading before", "ends past zero", "small cycle"],
)
def test_a_stretch_of_one_or_two_readings_keeps_its_reversals(torque: list[float]) -> None:
    loop = Loop(np.array(torque), np.array(torque) / 2e4)
    points = turning_points(loop.torque)
    reached = reduce_loop(loop, points, 0.0).path.reversal_torque
    np.testing.assert_allclose(reached, loop.torque[points[1:]], atol=1e-9)


def test_a_slow_ramp_is_not_averaged_with_a_steep_one() -> None:
    """Over as many readings as suit the slow one the top would be some 1 Nm too low."""
    torque = np.array([*np.linspace(0.0, 100.0, 2001), *np.linspace(98.0, -100.0, 100)])
    loop, noise = Loop(torque, torque / 2e4), 0.1
    reached = reduce_loop(loop, turning_points(torque), noise).path.reversal_torque
    assert reached is not None
    assert reached[0] == pytest.approx(100.0, abs=noise)
