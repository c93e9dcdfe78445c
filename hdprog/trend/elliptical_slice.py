"""Elliptical slices for many chains side by side (Murray, Adams & MacKay, AISTATS 2010).

Where the density is a Gaussian's times a weight, a chain's numbers and fresh ones of that Gaussian
span an ellipse on which every point is as likely by the Gaussian; the weight alone says how far
along it the chain may turn.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray

_BRACKET = 2.0  # rad, first bracket of a slice
_SHRINKS = 60
_AHEAD = 4  # draws of a chain at most that are looked at together: more are mostly for nothing


def between(one: FloatArray, other: FloatArray, angle: FloatArray) -> FloatArray:
    """On the ellipse through (chains, k) numbers and others about zero, by angles (chains,)."""
    return np.asarray(np.cos(angle)[:, None] * one + np.sin(angle)[:, None] * other)


def turned(
    at_angles: Callable[[NDArray[np.intp], FloatArray], tuple[FloatArray, FloatArray]],
    height: FloatArray,
    now: tuple[FloatArray, FloatArray],
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Turn chains along their ellipses to angles whose log weight is above a height.

    A bracket of angles shrinks towards zero, where a chain is, until a draw from it is inside.
    While few chains are left, several draws of each are looked at together: the brackets after
    a miss do not hang on by how much it missed.

    Parameters
    ----------
    at_angles : log weights and what belongs to them (rows, ...) of some chains at an angle each
    height : (chains,)
    now : the same at angle zero
    rng : source of randomness

    Returns
    -------
    angles (chains,), log weights and what belongs to them there
    """
    count = len(height)
    angle, weight, kept = np.zeros(count), now[0].copy(), now[1].copy()
    low = -_BRACKET * rng.uniform(size=count)
    high = low + _BRACKET
    turning = np.arange(count)
    shrinks = 0
    # Rounding alone can keep a chain out of a slice that holds where it is: it stays there.
    while turning.size and shrinks < _SHRINKS:
        ahead = min(count // turning.size, _AHEAD)
        shrinks += ahead
        tries = np.empty((turning.size, ahead))
        for number in range(ahead):
            at = rng.uniform(low[turning], high[turning])
            low[turning] = np.where(at < 0, at, low[turning])
            high[turning] = np.where(at < 0, high[turning], at)
            tries[:, number] = at
        found, belongs = at_angles(np.repeat(turning, ahead), tries.ravel())
        inside = found.reshape(tries.shape) > height[turning, None]
        row = np.flatnonzero(inside.any(axis=1))
        place = row * ahead + inside[row].argmax(axis=1)
        there = turning[row]
        angle[there] = tries.ravel()[place]
        weight[there], kept[there] = found[place], belongs[place]
        turning = np.delete(turning, row)
    return angle, weight, kept
