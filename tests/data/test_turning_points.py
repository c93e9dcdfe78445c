from __future__ import annotations

import time
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hdprog.data.turning_points
from hdprog.data.noise_level import channel_noise, noise_sd, quantisation_step
from hdprog.data.turning_points import smallest_swing, turning_points
from tests.data.samples import FloatArray, ramps


def zigzag(torque: list[float], swing: float) -> list[float]:
    """Reference: torques at the extremes, from the definition, one sample at a time."""
    found: list[float] = []
    high = low = torque[0]
    direction = 0
    for value in torque:
        high, low = max(high, value), min(low, value)
        if direction >= 0 and high - value >= swing:
            if direction > 0:
                found.append(high)
            direction, low = -1, value
        elif direction <= 0 and value - low >= swing:
            if direction < 0:
                found.append(low)
            direction, high = 1, value
        if direction < 0:
            high = low
        elif direction > 0:
            low = high
    return found


@given(st.lists(st.integers(-50, 50), min_size=2, max_size=60), st.integers(1, 40))
@settings(max_examples=300)
def test_extremes_are_those_of_the_definition(steps: list[int], swing: int) -> None:
    # Steps no larger than the swing: nothing here can pass for an isolated spike.
    torque = np.cumsum(np.clip(steps, -swing, swing)).astype(float)
    with patch.object(hdprog.data.turning_points, "last_before_reversal", _as_they_are):
        extremes = turning_points(torque, swing)
    # An extreme at the very last sample is that sample.
    assert torque[extremes[1:-1]].tolist() == zigzag(torque.tolist(), swing)
    turns = turning_points(torque, swing)
    assert turns[0] == 0
    assert turns[-1] == torque.size - 1
    assert (np.diff(turns) > 0).all()
    # The extreme of a corner may lie behind the reversal already.
    assert set((extremes - turns).tolist()) <= {0, 1}


def _as_they_are(torque: FloatArray, extremes: np.ndarray, noise: float) -> np.ndarray:
    return extremes


def test_corners_of_clean_ramps_are_found_exactly() -> None:
    torque = ramps(0, 40, -40, 40, 10, 30, -40, 0, samples=51)
    assert turning_points(torque).tolist() == list(range(0, 351, 50))


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.5])
@pytest.mark.parametrize("step", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("samples", [60, 400, 5000])
def test_noise_and_resolution_make_none(noise: float, step: float, samples: int) -> None:
    # With normal noise one false turn in this grid of 27 has a chance below 1e-3.
    rng = np.random.default_rng(7)
    torque = ramps(0, 40, 40, -40, -40, 40, 0, samples=samples)
    torque = torque + noise * rng.standard_normal(torque.size)
    if step:
        torque = np.round(torque / step) * step
    turns = turning_points(torque)
    assert len(turns) == 5
    assert torque[turns[1:-1]] == pytest.approx([40, -40, 40], abs=4 * noise + step + 1e-9)


def test_minor_loops_above_the_threshold_are_kept_and_smaller_ones_are_not() -> None:
    torque = ramps(0, 30, 27, 40, 0, samples=201)
    assert len(turning_points(torque, 2.5)) == 5
    assert len(turning_points(torque, 3.1)) == 3


def test_a_hold_ends_at_its_last_sample() -> None:
    torque = ramps(0, 40, 40, 0, samples=1001)
    assert turning_points(torque).tolist() == [0, 2000, 3000]


def test_an_isolated_spike_is_no_reversal() -> None:
    torque = ramps(0, 40, 0, samples=301)
    torque[100] += 30
    torque[450] -= 25
    assert turning_points(torque).tolist() == [0, 300, 600]


def test_short_and_constant_records() -> None:
    assert turning_points(np.array([])).tolist() == []
    assert turning_points(np.array([1.0])).tolist() == [0]
    assert turning_points(np.full(30, 2.0)).tolist() == [0, 29]


def test_a_million_samples_take_under_two_seconds() -> None:
    rng = np.random.default_rng(3)
    torque = ramps(*[-40, 40] * 30, samples=1_000_001 // 59)
    torque += 0.3 * rng.standard_normal(torque.size)
    before = time.process_time()
    assert len(turning_points(torque)) == 60
    assert time.process_time() - before < 2.0


def noisy_ramp(sd: float, size: int = 4000) -> FloatArray:
    return ramps(0, 50, 0, samples=size // 2) + sd * np.random.default_rng(1).standard_normal(
        2 * (size // 2) - 1
    )


@pytest.mark.parametrize("sd", [0.01, 0.3])
def test_noise_is_estimated_within_a_tenth(sd: float) -> None:
    # The estimate's own sd is below 2 % here; the seed is fixed.
    assert noise_sd(noisy_ramp(sd)) == pytest.approx(sd, rel=0.1)


@pytest.mark.parametrize(("cycles", "readings"), [(10, 100), (20, 200), (40, 40), (200, 30)])
def test_many_cycles_are_neither_noise_nor_hide_their_turns(cycles: int, readings: int) -> None:
    # A hundredth of these records is a good part of a cycle, or more than one. Few readings of a
    # short window give the noise to some 10 %, and turns add a little; the seed is fixed.
    samples, sd = readings // 2 + 1, 0.03
    torque = ramps(*[0, *[80, -80] * cycles, 0], samples=samples)
    torque += sd * np.random.default_rng(1).standard_normal(torque.size)
    assert noise_sd(torque) == pytest.approx(sd, rel=0.35)
    assert len(turning_points(torque)) == 2 * cycles + 2


def test_resolution_is_found_and_counts_as_noise() -> None:
    coarse = np.round(ramps(0, 5, 0, samples=2001) / 0.1) * 0.1
    assert quantisation_step(coarse) == pytest.approx(0.1)
    assert channel_noise(coarse) >= 0.1 / np.sqrt(12)
    assert quantisation_step(np.round(noisy_ramp(0.1) / 0.05) * 0.05) == pytest.approx(0.05)


@pytest.mark.parametrize(
    "values",
    [noisy_ramp(0.1), ramps(0, 40, 0, samples=301), ramps(0, 40, 40, 0, samples=301), np.ones(50)],
)
def test_no_resolution_is_invented(values: FloatArray) -> None:
    assert quantisation_step(values) is None


def test_swing_is_at_least_a_hundredth_of_the_span() -> None:
    assert smallest_swing(ramps(-10, 40, samples=300)) == pytest.approx(0.5)
