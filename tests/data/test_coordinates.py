"""Coordinates beside the torque: denoised loading rate, scales, and what blocks make of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.data.coordinates import loading_rate, record_course
from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop, whole_course
from hdprog.data.turning_points import turning_points
from hdprog.physics.coordinates import coordinates
from hdprog.physics.torque_path import TorquePath
from tests.data.samples import PEAK, FloatArray, ramps, twist

STARTS = np.array([0, 301, 901])
RATES = np.array([2.0, -4.0, 1.0])


def uneven_ramps() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Ramps at three rates, unevenly sampled: torque, time and the true rate of every reading."""
    rng = np.random.default_rng(0)
    step = rng.uniform(0.02, 0.08, 1200)
    rate = np.repeat(RATES, [300, 600, 300])
    time = np.concatenate([[0.0], np.cumsum(step)])
    torque = np.concatenate([[0.0], np.cumsum(rate * step)])
    return torque, time, np.concatenate([rate[:1], rate])


def test_rate_of_exact_ramps() -> None:
    torque, time, rate = uneven_ramps()
    np.testing.assert_allclose(loading_rate(torque, time, STARTS, 0.0), rate, rtol=1e-9)


def test_rate_of_noisy_ramps_has_the_error_it_promises() -> None:
    """A standard error of 5 % whatever the noise; up to 8 % where the part is only three readings.

    5 standard errors for the worst of 1200 readings: false alarm 7e-4 a noise.
    """
    rng = np.random.default_rng(1)
    time = np.linspace(0, 60, 1201)
    torque, rate = 2.0 * time, np.full(time.size, 2.0)
    for noise in (0.01, 0.05, 0.2):
        noisy = torque + noise * rng.standard_normal(time.size)
        error = loading_rate(noisy, time, np.array([0]), noise) / rate - 1
        promised = 0.08 if noise < 0.02 else 0.055
        assert np.abs(error).max() < 5 * promised
        assert np.sqrt(np.mean(error**2)) < 1.15 * promised
        assert np.abs(error.mean()) < 0.02
        # Raw differences would be of no use.
        raw = np.diff(noisy) / np.diff(time) / 2.0 - 1
        assert np.std(raw) > 2 * np.std(error)


def test_rate_of_a_sine() -> None:
    """Without noise to the curvature of three readings, with noise to the promised error."""
    rng = np.random.default_rng(2)
    time = np.linspace(0, 10, 1001)
    omega = 2 * np.pi / 10
    torque, wanted = 50 * np.sin(omega * time), 50 * omega * np.cos(omega * time)
    starts = np.array([0, 251, 751])
    exact = loading_rate(torque, time, starts, 0.0)
    # At a stretch's ends the line leans to one side by one reading.
    assert np.abs(exact - wanted).max() < 1.05 * 50 * omega**2 * 0.01
    noise = 0.05
    found = loading_rate(torque + noise * rng.standard_normal(time.size), time, starts, noise)
    error = found - wanted
    # 5 % of the mean rate of a stretch, 20 Nm/s, at 5 standard errors, and the curvature over the
    # half window of five readings; false alarm below 1e-3.
    assert np.abs(error).max() < 5 * 0.05 * 20 + 50 * omega**2 * 0.05
    assert np.sqrt(np.mean(error**2)) < 0.05 * 20 * 1.3


def test_rate_of_a_hold_and_of_the_shortest_stretches() -> None:
    time = np.arange(200.0)
    torque = np.concatenate([np.linspace(0, 40, 100), np.full(100, 40.0)])
    rate = loading_rate(torque, time, np.array([0]), 0.0)
    np.testing.assert_allclose(rate[:98], 40 / 99, rtol=1e-9)
    np.testing.assert_allclose(rate[102:], 0.0, atol=1e-12)
    torque, time = np.array([0.0, 1.0, 3.0, 2.0, 4.0, 7.0]), np.arange(6.0)
    found = loading_rate(torque, time, np.array([0, 3, 4]), 0.0)
    # One reading alone takes the line through its neighbours, two make their own.
    assert found[3] == pytest.approx(0.5)
    assert found[4:].tolist() == pytest.approx([3.0, 3.0])


def recorded(samples: int, timed: bool = True) -> Loop:
    """A two-sided loop with noise and every further column."""
    rng = np.random.default_rng(3)
    torque = ramps(0, PEAK, -PEAK, PEAK, 0, samples=samples // 4 + 1)
    order = np.linspace(0, 1, torque.size)
    return Loop(
        torque=torque + 0.02 * rng.standard_normal(torque.size),
        angle=twist(torque),
        time=7.0 + 100 * order**1.2 if timed else None,
        temperature=20 + 3 * order,
        output_angle=0.3 - 0.5 * order,
    )


def whole_of(loop: Loop) -> TorquePath:
    return TorquePath.exact(loop.torque)


def test_scales_of_a_record() -> None:
    loop = recorded(400)
    course = record_course(loop, whole_of(loop), 0.02)
    scales = course.scales
    assert scales.torque == np.abs(loop.torque).max()
    assert scales.angle == pytest.approx(np.ptp(loop.angle) / 2)
    assert scales.duration == pytest.approx(100.0)
    assert scales.sweep == pytest.approx(0.5)
    assert scales.readings == len(loop)
    assert course.time is not None
    assert course.time[0] == 0.0
    assert course.clock[[0, -1]].tolist() == [0.0, 1.0]
    untimed = record_course(recorded(400, timed=False), whole_of(loop), 0.02)
    assert (untimed.time, untimed.rate) == (None, None)
    assert (untimed.scales.duration, untimed.scales.rate) == (None, None)
    np.testing.assert_array_equal(untimed.clock, untimed.order)
    bare = Loop(loop.torque, loop.angle)
    assert record_course(bare, whole_of(loop), 0.02).scales.sweep is None


def test_blocks_are_means_of_their_readings() -> None:
    loop = recorded(4000)
    points = turning_points(loop.torque)
    kept = np.ones(len(loop), dtype=bool)
    kept[500:520] = kept[2000] = False
    whole = whole_course(loop, points, 0.02)
    reduced = reduce_loop(loop, points, 0.02, kept, 120)
    course = reduced.course
    assert 80 < reduced.angle.size < 160
    blocks = [np.flatnonzero(reduced.block_of == number) for number in range(reduced.angle.size)]
    assert sum(block.size for block in blocks) == kept.sum()
    pairs = {
        "torque": (course.path.torque, loop.torque),
        "order": (course.order, whole.order),
        "time": (course.time, loop.time),
        "rate": (course.rate, whole.rate),
        "temperature": (course.temperature, loop.temperature),
        "output_angle": (course.output_angle, loop.output_angle),
        "angle": (reduced.angle, loop.angle),
    }
    for name, (averaged, read) in pairs.items():
        assert averaged is not None
        assert read is not None
        wanted = [read[block].mean() for block in blocks]
        np.testing.assert_allclose(averaged, wanted, rtol=1e-10, err_msg=name)
    assert course.scales == whole.scales
    # No block mixes both directions of torque.
    np.testing.assert_array_equal(
        course.path.direction, [np.unique(whole.path.direction[block]).item() for block in blocks]
    )


def test_a_short_record_keeps_its_readings() -> None:
    loop = recorded(200)
    points = turning_points(loop.torque)
    whole = whole_course(loop, points, 0.02)
    course = reduce_loop(loop, points, 0.02).course
    for name in ("order", "time", "rate", "temperature", "output_angle"):
        np.testing.assert_allclose(getattr(course, name), getattr(whole, name), rtol=1e-12)


def test_blocks_of_an_untimed_record() -> None:
    loop = recorded(4000, timed=False)
    course = reduce_loop(loop, turning_points(loop.torque), 0.02).course
    assert (course.time, course.rate) == (None, None)


def test_travel_is_counted_from_the_reversal() -> None:
    torque = np.array([0.0, 10.0, 30.0, 20.0, -10.0, 0.0, 5.0])
    course = record_course(Loop(torque, torque), TorquePath.exact(torque), 0.0)
    assert course.turned_at.tolist() == [0.0, 0.0, 0.0, 30.0, 30.0, -10.0, -10.0]
    assert course.travel.tolist() == [0.0, 10.0, 30.0, 10.0, 40.0, 10.0, 15.0]
    assert course.load.tolist() == pytest.approx((torque / 30).tolist())


def test_coordinates_that_a_residual_may_follow() -> None:
    loop = recorded(400)
    course = record_course(loop, whole_of(loop), 0.02)
    always = {"torque", "branch", "distance_since_reversal"}
    columns = {"temperature", "output_angle"}
    timed = always | columns | {"time", "time_since_reversal", "rate"}
    assert set(coordinates(course)) == timed
    untimed = record_course(recorded(400, timed=False), whole_of(loop), 0.02)
    assert set(coordinates(untimed)) == always | columns | {"order"}
    still = replace(course, temperature=np.full(len(loop), 21.0))
    assert set(coordinates(still)) == timed - {"temperature"}


def test_time_since_a_reversal_starts_at_it() -> None:
    torque, time = ramps(0, 10, -10, samples=6), np.arange(11.0)
    course = record_course(Loop(torque, torque, time), TorquePath.exact(torque), 0.0)
    since = coordinates(course)["time_since_reversal"]
    assert since.tolist() == [0, 1, 2, 3, 4, 5, 1, 2, 3, 4, 5]
