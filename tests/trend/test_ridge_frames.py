"""Shifts of all tests along one ridge coordinate, and differences taken apart by coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.inference.ridge_coordinates import from_unconstrained
from hdprog.trend.ridge_frames import along_ridges, parts
from hdprog.trend.ridge_map import RidgeMap, onto_ridges
from hdprog.trend.wear_coordinates import from_loop, to_loop
from tests.trend.stand_in import ALPHA, NEW, PRIOR, WEAR

SIZE = 9  # an effect's amplitude behind the eight
POINTS = np.stack([np.append(from_loop(NEW + part * WEAR), 0.3) for part in (0.5, 0.8)])
MAPS = [RidgeMap(point, ALPHA, PRIOR.softplus_scale) for point in POINTS]
FRICTION = [5, 6, 7]


def ridge_coordinates(tangents: np.ndarray) -> np.ndarray:
    """(draws, tests, 8) of draws on the tangents."""
    met, _ = onto_ridges(MAPS, tangents)
    flat = to_loop(met[..., :8]).reshape(-1, 8)
    return from_unconstrained(flat, ALPHA, PRIOR.softplus_scale).reshape(len(tangents), -1, 8)


def test_a_shift_changes_one_ridge_coordinate_of_all_tests_alike() -> None:
    shifts = along_ridges(MAPS, SIZE)
    here = ridge_coordinates(POINTS[None])[0]
    there = ridge_coordinates(POINTS + 0.01 * shifts)
    for number, changed in enumerate(there - here):
        wanted = np.zeros((2, 8))
        wanted[:, number] = changed[0, number]
        assert changed[0, number] > 0
        assert changed == pytest.approx(wanted, abs=1e-6)


def test_a_part_of_a_difference_leaves_the_other_ridge_coordinates() -> None:
    apart = 0.01 * np.random.default_rng(1).standard_normal((2, SIZE))
    _, of_friction, whole = parts(MAPS, SIZE)
    part = np.einsum("tij,tj->ti", of_friction, apart)
    here, there, all_the_way = ridge_coordinates(np.stack([POINTS, POINTS + part, POINTS + apart]))
    wanted = here.copy()
    wanted[:, FRICTION] = all_the_way[:, FRICTION]
    assert there == pytest.approx(wanted, abs=1e-6)
    assert not part[:, 8].any()
    assert np.array_equal(np.einsum("tij,tj->ti", whole, apart), apart)


def test_a_loop_without_a_ridge_stays_where_it_is() -> None:
    nowhere = POINTS[0].copy()
    nowhere[3], nowhere[4] = 69.0, -324.0  # teeth that carry everything and are met at no torque
    maps = [MAPS[0], RidgeMap(nowhere, ALPHA, PRIOR.softplus_scale)]
    assert not along_ridges(maps, SIZE)[:, 1].any()
    cup_and_teeth, of_friction, whole = parts(maps, SIZE)
    assert not cup_and_teeth[1].any()
    assert not of_friction[1].any()
    assert np.array_equal(whole[1], np.eye(SIZE))
