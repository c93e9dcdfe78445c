"""What a difference of states is made of, by ridge coordinates, for moves that shift all tests."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.ridge_map import RidgeMap

_COUNT = len(NAMES)
_PARTS = ([2, 3, 4], [5, 6, 7])
"""Ridge coordinates by what they are of: cup and teeth, and friction."""


def parts(maps: Sequence[RidgeMap], size: int) -> FloatArray:
    """(parts, tests, n, tests, n) what of a difference of states lies in some ridge coordinates.

    Of each test by itself, as the whole difference is, which is the last part. Before it the same
    for all tests alike, by their mean: what tests differ by is left as it is, and what they have
    in common may go far. Loops without a ridge have no part but the last.
    """
    tests, each = range(len(maps)), np.zeros((len(_PARTS), len(maps), size, size))
    for test, one in enumerate(maps):
        if one.inverse is not None:
            _, derivative = one.ridge
            for number, part in enumerate(_PARTS):
                each[number, test, :_COUNT, :_COUNT] = one.inverse[:, part] @ derivative[part]
    apart = np.zeros((len(_PARTS), len(maps), size, len(maps), size))
    apart[:, tests, :, tests] = each.swapaxes(0, 1)
    alike = np.einsum("ptij,psjk->ptisk", each, each) / len(maps)
    whole = np.eye(len(maps) * size).reshape(apart[0].shape)
    return np.concatenate([apart, alike, whole[None]])
