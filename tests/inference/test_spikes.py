"""Isolated spikes are named, and nothing else is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from hdprog.inference.spikes import remark_on_spikes, spikes

NO_TURNS = np.array([0, 0])


def named(residual: np.ndarray, turns: np.ndarray = NO_TURNS, step: float = 0.0) -> np.ndarray:
    return spikes(residual, np.ones(residual.size), turns, step)


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
