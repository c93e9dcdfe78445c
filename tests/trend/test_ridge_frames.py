"""Differences of states taken apart by ridge coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.inference.ridge_coordinates import from_unconstrained
from hdprog.trend.ridge_frames import parts
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


def test_a_part_of_a_difference_leaves_the_other_ridge_coordinates() -> None:
    apart = 0.01 * np.random.default_rng(1).standard_normal((2, SIZE))
    _, of_friction, _, _, whole = parts(MAPS, SIZE)
    part = np.einsum("tisj,sj->ti", of_friction, apart)
    here, there, all_the_way = ridge_coordinates(np.stack([POINTS, POINTS + part, POINTS + apart]))
    wanted = here.copy()
    wanted[:, FRICTION] = all_the_way[:, FRICTION]
    assert there == pytest.approx(wanted, abs=1e-6)
    assert not part[:, 8].any()
    assert np.array_equal(np.einsum("tisj,sj->ti", whole, apart), apart)


def test_what_two_tests_share_of_a_difference_is_their_mean() -> None:
    rng = np.random.default_rng(2)
    same = [MAPS[0], MAPS[0]]
    of_each, of_all = parts(same, SIZE)[[1, 3]]
    common = np.repeat(0.01 * rng.standard_normal((1, SIZE)), 2, axis=0)
    own = 0.01 * rng.standard_normal((1, SIZE)) * [[1.0], [-1.0]]

    def shift(of: np.ndarray, apart: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("tisj,sj->ti", of, apart))

    assert shift(of_all, common) == pytest.approx(shift(of_each, common), abs=1e-12)
    assert shift(of_all, own) == pytest.approx(0.0, abs=1e-12)
    # Of tests at different points: no coordinate changes but those of friction.
    moved = shift(parts(MAPS, SIZE)[3], common + own)
    here, there = ridge_coordinates(np.stack([POINTS, POINTS + moved]))
    assert np.delete(there - here, FRICTION, axis=1) == pytest.approx(0.0, abs=1e-6)


def test_a_loop_without_a_ridge_stays_where_it_is() -> None:
    nowhere = POINTS[0].copy()
    nowhere[3], nowhere[4] = 69.0, -324.0  # teeth that carry everything and are met at no torque
    maps = [MAPS[0], RidgeMap(nowhere, ALPHA, PRIOR.softplus_scale)]
    *some, whole = parts(maps, SIZE)
    for part in some:
        assert not part[1].any()
        assert not part[:, :, 1].any()
    assert np.array_equal(whole.reshape(2 * SIZE, -1), np.eye(2 * SIZE))
