"""Readings about a reversal lie on the side that the torque was on."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.data.loop import Loop
from hdprog.data.noise_level import channel_noise
from hdprog.data.reduce import whole_course
from hdprog.data.reversal_sides import last_before_reversal
from hdprog.data.turning_points import turning_points
from tests.data.samples import FloatArray

NOISE = 0.07


def trapezoid(per_ramp: int, held: int, seed: int = 0) -> tuple[FloatArray, list[int]]:
    """Up, hold, down, hold, up with noise; the last readings of the holds."""
    up = np.linspace(0, 60, per_ramp + 1)
    down = np.linspace(60, -60, 2 * per_ramp + 1)
    torque = np.concatenate([up, np.full(held, 60.0), down[1:], np.full(held, -60.0), -down[1:]])
    ends = [per_ramp + held, 3 * per_ramp + 2 * held]
    rng = np.random.default_rng(seed)
    return torque + NOISE * rng.standard_normal(torque.size), ends


@pytest.mark.parametrize(("per_ramp", "held"), [(50, 6), (50, 40), (300, 20), (2000, 900)])
def test_a_noisy_hold_belongs_to_the_ramp_before_it(per_ramp: int, held: int) -> None:
    """Nineteen of twenty are found where the line of the ramp behind them can be told to be."""
    off = []
    for seed in range(40):
        torque, ends = trapezoid(per_ramp, held, seed)
        found = turning_points(torque)
        assert found.size == 4
        off += np.abs(found[1:-1] - ends).tolist()
    told = 1 + 4 * NOISE / (60 / per_ramp)
    assert np.mean(np.array(off) <= told) >= 0.95


def corner(offset: float, step: float = 1.3) -> FloatArray:
    """A valley between two readings, `offset` of a step behind the reading 40; even ramps."""
    at = np.arange(120.0)
    return step * np.abs(at - 40 - offset)


@pytest.mark.parametrize("offset", [-0.4, -0.2, 0.2, 0.4])
def test_a_corners_reading_lies_on_the_side_of_its_line(offset: float) -> None:
    rng = np.random.default_rng(3)
    torque = corner(offset)
    torque += 0.02 * rng.standard_normal(torque.size)
    last = 40 if offset > 0 else 39
    points = turning_points(torque)
    assert points.tolist() == [0, last, 119]
    loop = Loop(torque=torque, angle=torque / 2e4)
    reached = whole_course(loop, points, channel_noise(torque, None)).path.reached[0]
    assert reached == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("seed", range(20))
def test_a_rounded_peak_is_no_hold(seed: int) -> None:
    phase = np.linspace(0, 2 * np.pi, 400)
    rng = np.random.default_rng(seed)
    torque = 60 * np.sin(phase) + NOISE * rng.standard_normal(phase.size)
    extremes = np.array([np.argmax(torque), np.argmin(torque)])
    extremes.sort()
    np.testing.assert_array_equal(last_before_reversal(torque, extremes, NOISE), extremes)


def test_uneven_ramps_have_their_corner_and_round_ones_do_not() -> None:
    rng = np.random.default_rng(6)
    steps = np.concatenate([rng.uniform(3.3, 5.1, 40), -rng.uniform(3.3, 5.1, 80)])
    torque = np.cumsum(steps)
    path = whole_course(Loop(torque=torque, angle=torque / 2e4), turning_points(torque), NOISE).path
    assert torque[39] < path.reached[0] < torque[39] + 3
    round_one = 60 * np.cos(np.linspace(-2, 4, 60))
    points = turning_points(round_one)
    path = whole_course(Loop(torque=round_one, angle=round_one / 2e4), points, 0.01).path
    assert path.reached[0] == round_one[points[1]]
