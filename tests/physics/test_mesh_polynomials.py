"""Many draws' teeth by polynomials are those of each draw by itself, whatever the draws."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from hdprog.physics import mesh_polynomials
from hdprog.physics.elastic import elastic_angle
from hdprog.physics.mesh_polynomials import pay, within_reach
from hdprog.physics.torque_path import TorquePath

DRAWS = 40
TURNS = (0.3, 60.0, -55.0, 48.0)


def blocks(spread: float = 0.6) -> TorquePath:
    """Blocks along a two-sided loop, some of them around zero torque."""
    ramps = [np.linspace(a, b, 60) for a, b in itertools.pairwise(TURNS)]
    path = TorquePath.exact(np.concatenate(ramps))
    return TorquePath(path.torque, path.starts, path.rising, np.full(path.torque.size, spread**2))


def draws(width: float, T_T: float, log_ratio: float = 0.1) -> dict[str, np.ndarray]:
    """Draws whose log(a/b) spreads over a width, and whose T_T by a tenth."""
    rng = np.random.default_rng(20261128)
    b = 15_000 * np.exp(rng.uniform(-0.1, 0.1, DRAWS))
    ratio = np.exp(log_ratio + width * np.linspace(-0.5, 0.5, DRAWS))
    ends = T_T * np.exp(rng.uniform(-0.1, 0.1, DRAWS))
    return {"K_F": rng.uniform(2e4, 4e4, DRAWS), "a": b * ratio, "b": b, "T_T": ends}


def one_by_one(path: TorquePath, values: dict[str, np.ndarray]) -> np.ndarray:
    each = [{name: value[[k]] for name, value in values.items()} for k in range(DRAWS)]
    return np.vstack([elastic_angle(path, one) for one in each])


def error(path: TorquePath, values: dict[str, np.ndarray]) -> float:
    """Largest, over the largest angle."""
    alone = one_by_one(path, values)
    assert not path.worked_out
    together = elastic_angle(path, values)
    assert path.worked_out, "polynomials were not used"
    return float(np.abs(together - alone).max() / np.abs(alone).max())


@pytest.mark.parametrize("T_T", [0.0, 0.4, 3.0, 14.0, 58.0, 400.0])
@pytest.mark.parametrize("width", [0.0, 0.7, 2.9, 9.0])
@pytest.mark.parametrize("log_ratio", [-12.0, -3.1, 0.1, 1.7])
def test_together_as_one_by_one(width: float, T_T: float, log_ratio: float) -> None:
    values = draws(width, T_T, log_ratio)
    assert error(blocks(), values) < 2e-14
    path = TorquePath.exact(np.tile(blocks().torque, 2))
    assert error(path, values) < 2e-14


def test_one_size_for_all_draws_will_do() -> None:
    values = draws(0.7, 14.0) | {"K_F": np.array(3e4), "T_T": np.array(14.0)}
    filled = {name: np.broadcast_to(value, DRAWS) for name, value in values.items()}
    path = blocks()
    np.testing.assert_array_equal(elastic_angle(path, values), elastic_angle(path, filled))


@pytest.mark.parametrize("name", ["T_T", "K_F"])
def test_a_draw_that_is_no_number_leaves_the_others_alone(name: str) -> None:
    values, path = draws(0.7, 0.4), blocks()
    clean = elastic_angle(path, values)
    values[name][7] = math.nan
    found = elastic_angle(path, values)
    assert np.isnan(found[7]).all()
    np.testing.assert_array_equal(np.delete(found, 7, axis=0), np.delete(clean, 7, axis=0))


def test_a_draw_beyond_their_reach_is_worked_out_by_itself() -> None:
    values, path = draws(0.7, 14.0), blocks()
    clean = elastic_angle(path, values)
    for far in (0.0, 400.0, 1e70):
        values["a"][7] = values["b"][7] * far
        alone = {name: value[[7]] for name, value in values.items()}
        with np.errstate(divide="ignore"):  # 2/a, whose bend then is none
            found, one = elastic_angle(path, values), elastic_angle(blocks(), alone)
        np.testing.assert_array_equal(found[[7]], one)
        np.testing.assert_allclose(np.delete(found, 7, axis=0), np.delete(clean, 7, axis=0), 1e-13)


def test_draws_that_are_all_beyond_their_reach_have_none() -> None:
    values, path = draws(0.7, 14.0, log_ratio=9.0), blocks()
    np.testing.assert_array_equal(elastic_angle(path, values), one_by_one(path, values))
    assert not path.worked_out


def test_too_few_polynomials_would_be_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh_polynomials, "_COUNT", 8)
    assert error(blocks(), draws(1.9, 14.0)) > 1e-11


def test_a_path_works_its_coefficients_out_once() -> None:
    path = blocks()
    for log_ratio in (0.1, 1.4, 0.1):
        values = draws(0.7, 14.0, log_ratio)
        together = elastic_angle(path, values)
        np.testing.assert_allclose(together, one_by_one(path, values), rtol=1e-12, atol=1e-18)
    assert len(path.worked_out) == 1


@pytest.mark.parametrize(
    ("ratio", "held"),
    [(0.9, True), (1e-200, True), (0.0, False), (6.0, True), (7.0, False), (math.nan, False)],
)
def test_how_far_polynomials_reach(ratio: float, held: bool) -> None:
    assert within_reach(np.array([ratio]), 60.0) == [held]


def test_of_few_draws_or_torques_there_are_none() -> None:
    assert pay(40, 90, averages=True)
    assert not pay(5, 90, averages=True)
    assert not pay(40, 60, averages=True)


def test_of_single_readings_polynomials_pay_later() -> None:
    assert not pay(40, 90, averages=False)
    assert pay(40, 200, averages=False)


def test_without_any_torque_there_is_no_angle() -> None:
    path = TorquePath.exact(np.zeros(300))
    assert not elastic_angle(path, draws(0.7, 14.0)).any()
