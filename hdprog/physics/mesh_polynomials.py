"""Tooth-mesh torsion of many draws along one torque path, as a product of matrices.

Below T_T the torsion (17, 19) is F(T, r)/b with r = a/b and F = log(1 + T r)/r, averages over
blocks included. With s = log(1 + r T_max) the product F·(1 + r T_max) is analytic up to π to both
sides of the real axis, since T is T_max at most, and changes little: a few Chebyshev polynomials
give it to rounding (Trefethen, Approximation Theory and Approximation Practice, 2013, ch. 8). The
torsion is then the polynomials of each draw times the coefficients of each sample.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray

_WIDTH = 6.0  # of the interval in s, from 0: few draws of a loop's posterior lie beyond
_ERROR = 1e-15
# How many polynomials give F to rounding: Chebyshev series shrink by the ellipse that is analytic.
_COUNT = math.ceil(-math.log(_ERROR) / math.asinh(2 * math.pi / _WIDTH))
# Samples for each polynomial from which a product of matrices is the faster way; averages over
# blocks, three times as dear sample by sample, pay for it sooner.
_WORTH, _WORTH_OF_AVERAGES = 5, 2
# Polynomials for each draw up to which they pay: their coefficients last, and most paths are
# followed many times.
_MOST_FOR_A_DRAW = 3


def pay(draws: int, samples: int, *, averages: bool) -> bool:
    """Whether so many draws and samples are worth polynomials; with few of either F itself is.

    `averages` tells whether samples are averages over blocks.
    """
    worth = _WORTH_OF_AVERAGES if averages else _WORTH
    return samples >= worth * _COUNT and _MOST_FOR_A_DRAW * draws >= _COUNT


def within_reach(ratio: FloatArray, largest: float) -> NDArray[np.bool_]:
    """Whether polynomials hold for ratios a/b (draws,) up to a largest torque in Nm."""
    return (ratio > 0) & (np.log1p(ratio * largest) <= _WIDTH)


def polynomials(ratio: FloatArray, largest: float) -> FloatArray:
    """Rows (draws, polynomials) for ratios a/b (draws, 1); times coefficients they give F."""
    stretch = ratio * largest
    at = np.log1p(stretch) * (2 / _WIDTH) - 1
    turn = np.arccos(np.minimum(np.maximum(at, -1.0), 1.0))
    return np.asarray(np.cos(turn * np.arange(_COUNT)) / (1 + stretch))


def coefficients(torsion: Callable[[FloatArray], FloatArray], largest: float) -> FloatArray:
    """Coefficients (polynomials, samples) of F along a path of a largest torque in Nm.

    `torsion` gives F in rad·Nm/rad at ratios a/b (ratios, 1) in 1/Nm, as (ratios, samples).
    """

    def at(place: FloatArray) -> Any:  # of many samples at once, which NumPy's types leave out
        stretch = np.expm1(0.5 * _WIDTH * (place + 1))[:, None]
        return torsion(stretch / largest) * (1 + stretch)

    return np.ascontiguousarray(chebyshev.chebinterpolate(at, _COUNT - 1), dtype=np.float64)
