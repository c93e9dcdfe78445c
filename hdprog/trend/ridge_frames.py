"""Ways along the ridges of all loops at once, for moves that shift all tests together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.ridge_map import RidgeMap

_COUNT = len(NAMES)
_PARTS = ((2, 3, 4), (5, 6, 7), tuple(range(_COUNT)))
"""Ridge coordinates by what they are of: cup and teeth, friction, and all together."""
_UNITS = np.array([0.05, 0.3, 1.0, 1.0, 3.0, 0.3, 0.3, 0.05])
"""Of the ridge coordinates: how far they may lie from where a loop is linearised, by size."""


def along_ridges(maps: Sequence[RidgeMap], size: int) -> FloatArray:
    """Shifts on the tangents that change one ridge coordinate of all loops alike.

    Parameters
    ----------
    maps : of the loops; those without a ridge are not shifted
    size : n, numbers of a state

    Returns
    -------
    (8, tests, n)
    """
    shifts = np.zeros((_COUNT, len(maps), size))
    for test, (_, inverse) in enumerate(_frames(maps)):
        if np.isfinite(inverse).all():
            shifts[:, test, :_COUNT] = (inverse * _UNITS).T
    return shifts


def parts(maps: Sequence[RidgeMap], size: int) -> FloatArray:
    """(parts, tests, n, n) what of a difference of states lies in some ridge coordinates only.

    The last part is the difference as it is. Loops without a ridge have no other.
    """
    found = np.zeros((len(_PARTS), len(maps), size, size))
    found[-1] = np.eye(size)
    for test, (derivative, inverse) in enumerate(_frames(maps)):
        if np.isfinite(inverse).all():
            for number, part in enumerate(_PARTS[:-1]):
                chosen = list(part)
                found[number, test, :_COUNT, :_COUNT] = inverse[:, chosen] @ derivative[chosen]
    return found


def _frames(maps: Sequence[RidgeMap]) -> list[tuple[FloatArray, FloatArray]]:
    """Derivative of each loop's ridge coordinates (8, 8) and its inverse; not numbers without."""
    found = []
    for one in maps:
        _, derivative = one.ridge
        has_ridge = np.isfinite(derivative).all()
        inverse = np.linalg.inv(derivative) if has_ridge else np.full(derivative.shape, np.nan)
        found.append((derivative, np.asarray(inverse)))
    return found
