"""Jumps of the teeth's threshold: what stays, the way back, and the volume."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.physics.parameters import NAMES
from hdprog.trend.ridge_map import RidgeMap, onto_ridges
from hdprog.trend.threshold_jump import jumped
from hdprog.trend.wear_coordinates import from_loop, to_loop
from tests.trend.stand_in import ALPHA, NEW, PRIOR, WEAR

POINT = np.append(from_loop(NEW + 0.4 * WEAR), 0.3)  # an effect's amplitude behind the eight
RIDGE = RidgeMap(POINT, ALPHA, PRIOR.softplus_scale)
OTHERS = [place for place, name in enumerate(NAMES) if name not in ("b", "T_T")]


def met(states: np.ndarray) -> np.ndarray:
    return onto_ridges([RIDGE], states[:, None])[0][:, 0]


def mesh(coordinates: np.ndarray) -> np.ndarray:
    """a T_T + b in Nm/rad of wear coordinates (draws, n)."""
    parameters = PRIOR.to_physical(to_loop(coordinates)[:, :8])
    return parameters["a"] * parameters["T_T"] + parameters["b"]


@pytest.fixture(scope="module")
def states() -> np.ndarray:
    return POINT + 0.05 * np.random.default_rng(1).standard_normal((30, POINT.size))


@pytest.mark.parametrize("by", [-12.0, -0.5, 0.2])
def test_stiffness_above_the_threshold_stays_and_all_but_b(states: np.ndarray, by: float) -> None:
    there, volume = jumped(RIDGE, states, np.full(len(states), by))
    assert np.isfinite(volume).all()
    before, after = met(states), met(there)
    assert after[:, OTHERS] == pytest.approx(before[:, OTHERS], abs=1e-6)
    assert after[:, 8] == pytest.approx(before[:, 8])
    assert after[:, 4] - before[:, 4] == pytest.approx(by, abs=1e-6)
    assert mesh(after) == pytest.approx(mesh(before), rel=1e-6)


def test_the_way_back_leads_back(states: np.ndarray) -> None:
    by = np.random.default_rng(2).choice([-8.0, -0.5, 0.2], len(states))
    there, volume = jumped(RIDGE, states, by)
    back, volume_back = jumped(RIDGE, there, -by)
    assert back == pytest.approx(states, abs=1e-6)
    assert volume_back == pytest.approx(-volume, abs=1e-6)


@pytest.mark.parametrize("by", [-4.0, -0.5, 0.2])
def test_the_volume_is_the_determinant(states: np.ndarray, by: float) -> None:
    step = 1e-5
    around = np.concatenate([states[0] + step * np.eye(9), states[0] - step * np.eye(9)])
    there, _ = jumped(RIDGE, around, np.full(18, by))
    plus, minus = np.split(there, 2)
    _, wanted = np.linalg.slogdet((plus - minus) / (2 * step))
    _, found = jumped(RIDGE, states[:1], np.array([by]))
    assert found[0] == pytest.approx(wanted, abs=1e-4)


def test_where_b_would_be_negative_there_is_nothing_to_jump_to(states: np.ndarray) -> None:
    there, volume = jumped(RIDGE, states, np.full(len(states), 60.0))
    assert (volume == -np.inf).all()
    assert np.array_equal(there, states)
