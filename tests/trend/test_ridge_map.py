"""Draws on the tangent of a loop's ridge go onto it, one to one; where there is none, they stay."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.torque_path import TorquePath
from hdprog.trend.ridge_map import RidgeMap, onto_ridges
from hdprog.trend.wear_coordinates import from_loop, to_loop
from tests.trend.stand_in import ALPHA, NEW, PRIOR, loop_torque


def ridge_map(point: np.ndarray) -> RidgeMap:
    return RidgeMap(point, ALPHA, PRIOR.softplus_scale)


def onto_ridge(one: RidgeMap, tangent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(draws, 8) and (draws,) of a single loop's draws (draws, 8)."""
    found, log_slope = onto_ridges([one], tangent[:, None])
    return found[:, 0], log_slope[:, 0]


def test_the_point_itself_stays() -> None:
    point = from_loop(NEW)
    found, _ = onto_ridge(ridge_map(point), point[None])
    assert found[0] == pytest.approx(point, abs=1e-8)


def test_the_density_is_that_of_its_derivative() -> None:
    bend = ridge_map(from_loop(NEW))
    tangent = from_loop(NEW) + 0.1 * np.random.default_rng(1).standard_normal((30, 8))
    _, log_slope = onto_ridge(bend, tangent)
    inside = np.isfinite(log_slope)
    assert inside.sum() > 20
    step, here = 1e-5, onto_ridge(bend, from_loop(NEW)[None])[1][0]
    for one, expected in zip(tangent[inside], log_slope[inside], strict=True):
        near = np.concatenate([one + step * np.eye(8), one - step * np.eye(8)])
        moved, _ = onto_ridge(bend, near)
        derivative = (moved[:8] - moved[8:]) / (2 * step)
        assert np.linalg.slogdet(derivative)[1] == pytest.approx(expected - here, abs=1e-4)


def test_without_teeth_to_meet_draws_stay_where_they_are() -> None:
    nowhere = from_loop(NEW)
    nowhere[3], nowhere[4] = 69.0, -324.0  # b and T_T of a drive that healed without end
    tangent = nowhere + 0.1 * np.random.default_rng(2).standard_normal((20, 8))
    found, log_slope = onto_ridge(ridge_map(nowhere), tangent)
    assert np.array_equal(found, tangent)
    assert not log_slope.any()


def test_several_loops_go_onto_their_ridges_as_each_does_alone() -> None:
    """One of them has no ridge; one draw lies where no parameters are."""
    nowhere = from_loop(NEW)
    nowhere[3], nowhere[4] = 69.0, -324.0
    points = np.stack([from_loop(NEW), nowhere, from_loop(NEW) + 0.05])
    tangents = points + 0.1 * np.random.default_rng(3).standard_normal((20, 3, 8))
    tangents[0, 2, 0] -= 50.0
    maps = [ridge_map(point) for point in points]
    found, log_slope = onto_ridges(maps, tangents)
    for number, one in enumerate(maps):
        alone, its_slope = onto_ridge(one, tangents[:, number])
        np.testing.assert_allclose(found[:, number], alone, rtol=1e-12)
        np.testing.assert_allclose(log_slope[:, number], its_slope, rtol=1e-9, atol=1e-12)
    assert np.isneginf(log_slope[0, 2])
    assert np.array_equal(found[0, 2], tangents[0, 2])


@pytest.mark.parametrize(("b", "threshold"), [(69.0, -324.0), (10.0, -730.0)])
def test_without_a_ridge_there_is_no_other_cup(b: float, threshold: float) -> None:
    nowhere = from_loop(NEW)
    nowhere[3], nowhere[4] = b, threshold
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.array_equal(ridge_map(nowhere).with_cup(nowhere[0] - 0.4), nowhere)


@pytest.mark.parametrize("more", [-0.4, 0.3])
def test_with_another_cup_the_loop_stays_as_it_is(more: float) -> None:
    point = from_loop(NEW)
    other = ridge_map(point).with_cup(point[0] + more)
    assert other[0] == pytest.approx(point[0] + more)
    alone = point.copy()
    alone[0] += more

    def angle(wear: np.ndarray) -> np.ndarray:
        parameters = PRIOR.to_physical(to_loop(wear)[None])
        return torsion_angle(TorquePath.exact(loop_torque(80.0)), parameters, ALPHA)[0]

    moved, unlike = (np.std(angle(one) - angle(point)) for one in (other, alone))
    assert moved < 0.02 * unlike


def test_a_cup_too_soft_for_the_loop_takes_nearly_all_of_its_compliance() -> None:
    point = from_loop(NEW)
    other = ridge_map(point).with_cup(point[0] - 3.0)
    assert np.isfinite(other).all()
    assert point[0] - 3.0 < other[0] < point[0]
    assert other[3] > point[3]  # next to no compliance is left for the teeth
