"""Isolated spikes are named, and nothing else is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from hdprog.inference.spikes import remark_on_spikes, spikes

NO_TURNS = np.array([0, 0])


def named(
    residual: np.ndarray,
    turns: np.ndarray = NO_TURNS,
    step: float = 0.0,
    torque: np.ndarray | None = None,
) -> np.ndarray:
    torque = np.linspace(0.0, 1.0, residual.size) if torque is None else torque
    return spikes(residual, np.ones(residual.size), turns, step, torque)


def passes(count: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Torque of so many passes between -60 and 60 Nm, from 60 Nm on, and their turning points."""
    turns = np.arange(count + 1) * samples
    torque = np.interp(np.arange(turns[-1] + 1), turns, 60.0 * (-1.0) ** np.arange(count + 1))
    return torque, turns


@pytest.mark.parametrize("sizes", [(8.0, 1000.0), (8.0, 20.0)])
@pytest.mark.parametrize("sign", ["either", "up"])
@pytest.mark.parametrize("samples", [400, 5000])
def test_two_in_a_hundred_are_found(samples: int, sign: str, sizes: tuple[float, float]) -> None:
    rng = np.random.default_rng(4)
    series = rng.standard_normal(samples) + 3 * np.sin(np.arange(samples) / 200)
    planted = rng.random(samples) < 0.02
    size = np.exp(rng.uniform(*np.log(sizes), samples))
    size *= rng.choice([-1, 1], samples) if sign == "either" else 1
    found = named(series + planted * size)
    assert (planted & ~found).sum() <= 1
    assert (found & ~planted).mean() < 2e-3


@pytest.mark.parametrize("memory", [0.0, 20.0])
def test_a_calm_record_keeps_its_readings(memory: float) -> None:
    """At most one record in a hundred loses any, as the module says; noise may be slow."""
    rng = np.random.default_rng(5)
    phi = np.exp(-1 / memory) if memory else 0.0
    losing = 0
    for _ in range(200):
        slow = np.zeros(1500)
        for index, kick in enumerate(rng.standard_normal(1499)):
            slow[index + 1] = phi * slow[index] + kick
        losing += bool(named(slow + rng.standard_normal(1500)).any())
    # One in a thousand that this fails by chance at the stated rate.
    assert losing <= stats.binom.ppf(0.999, 200, 0.01)


def test_what_lasts_is_no_spike() -> None:
    rng = np.random.default_rng(6)
    series = rng.standard_normal(2000)
    series[700:] += 30.0  # a step
    series[1200:1210] -= 40.0  # an excursion
    series[1500:1800] += 20.0 * (np.arange(300) // 15 % 2)  # teeth
    assert not named(series).any()


def test_a_corner_of_the_course_is_no_spike() -> None:
    rng = np.random.default_rng(7)
    turns = np.arange(0, 2001, 100)
    series = rng.standard_normal(2001)
    series[turns[1:-1]] += (
        12.0  # every reversal rounded by less than the angle moves in one reading
    )
    assert not named(series, turns, step=15.0).any()
    series[900] += 200.0
    assert np.flatnonzero(named(series, turns, step=15.0)).tolist() == [900]


@pytest.mark.parametrize("count", [3, 4, 10])
def test_what_comes_back_at_a_torque_is_no_spike(count: int) -> None:
    """Play that is crossed in two readings: ahead of the others on one side, behind on the other.

    After the torque has changed its sign the angle is ahead, whichever way it goes.
    """
    torque, turns = passes(count, 101)
    rng = np.random.default_rng(11)
    series = rng.standard_normal(torque.size)
    rising = np.gradient(torque) > 0
    play: list[int] = []
    for start, end in pairwise(turns):
        stretch = np.arange(start, end)
        after = stretch[torque[stretch] > 0.1 if rising[start + 1] else torque[stretch] < -0.1]
        play += after[:2].tolist()
    series[play] += np.where(rising[play], 12.0, -12.0)
    assert not named(series, turns, torque=torque)[play].any()
    # A lone error is one still.
    series[40] += 60.0
    found = named(series, turns, torque=torque)
    assert found[40]
    assert not found[play].any()


@pytest.mark.parametrize("sizes", [(8.0, 1000.0), (8.0, 20.0)])
@pytest.mark.parametrize("count", [3, 20])
def test_errors_at_chance_torques_are_found_in_many_passes(
    count: int, sizes: tuple[float, float]
) -> None:
    """Records that keep any because others chanced to lie near: about three in a hundred."""
    torque, turns = passes(count, 150)
    rng = np.random.default_rng(12)
    missing = 0
    for _ in range(100):
        planted = rng.random(torque.size) < 0.02
        size = np.exp(rng.uniform(*np.log(sizes), torque.size)) * rng.choice([-1, 1], torque.size)
        # What is nearer to a turn than two readings may be a corner of the course.
        planted &= np.abs(torque) < 57.0
        found = named(rng.standard_normal(torque.size) + planted * size, turns, torque=torque)
        missing += int((planted & ~found).sum() > 1)
    assert missing <= stats.binom.ppf(0.999, 100, 0.03)


def test_a_record_full_of_them_has_none() -> None:
    rng = np.random.default_rng(8)
    series = rng.standard_normal(1000) + 30.0 * (rng.random(1000) < 0.2)
    assert not named(series).any()


def test_no_noise_at_all() -> None:
    series = np.zeros(100)
    assert not named(series).any()
    series[50] = 1.0
    assert named(series).sum() <= 1


def test_many_are_told_of() -> None:
    out = np.zeros(1000, dtype=bool)
    out[:5] = True
    assert remark_on_spikes(out) is None
    out[:23] = True
    assert "23 of 1000 readings (2.3%)" in (remark_on_spikes(out) or "")
