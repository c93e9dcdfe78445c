"""Tooth-mesh torsion of many draws along one torque path, as a product of matrices.

Below T_T the torsion (17, 19) is F(T, a/b)/b with F = log(1 + T a/b)/(a/b), averages over blocks
included. As a function of log(a/b) it is analytic up to π to both sides of the real axis, so that a
few Chebyshev polynomials give it to rounding (Trefethen, Approximation Theory and Approximation
Practice, 2013, ch. 8): the polynomials of each draw times the coefficients of each sample.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from hdprog.physics.parameters import FloatArray

_WIDEST = 4  # in log(a/b); polynomials of higher degree lose digits at the far ends
_ERROR = 1e-15
# Samples for each polynomial from which a product of matrices is the faster way; averages over
# blocks, three times as dear sample by sample, pay for it sooner.
_WORTH, _WORTH_OF_AVERAGES = 5, 2


def ends_of(ratio: FloatArray, samples: int, *, averages: bool) -> tuple[int, int] | None:
    """Whole numbers around log(a/b) of all draws (draws, 1), None where polynomials do not pay.

    Of fewer draws than polynomials, or of few samples, F itself is had as fast; ratios of zero, or
    that lie too far apart, have none. `averages` tells whether samples are averages over blocks.
    """
    least, most = float(ratio.min()), float(ratio.max())
    if not 0 < least <= most < math.inf:
        return None
    low, high = math.floor(math.log(least)), math.floor(math.log(most)) + 1
    paying = min(len(ratio), samples / (_WORTH_OF_AVERAGES if averages else _WORTH))
    if high - low > _WIDEST or _count(low, high) > paying:
        return None
    return low, high


@cache
def _count(low: int, high: int) -> int:
    """How many polynomials give F to rounding between two ends in log(a/b)."""
    nearest = 2 * math.pi / (high - low)
    return math.ceil(-math.log(_ERROR) / math.asinh(nearest))


def polynomials(ratio: FloatArray, low: int, high: int) -> FloatArray:
    """Chebyshev polynomials (draws, polynomials) at log(a/b) of draws (draws, 1)."""
    at = (2 * np.log(ratio) - (low + high)) / (high - low)
    turn = np.arccos(np.minimum(np.maximum(at, -1.0), 1.0))
    return np.asarray(np.cos(turn * np.arange(_count(low, high))))


def coefficients(torsion: Callable[[FloatArray], FloatArray], low: int, high: int) -> FloatArray:
    """Coefficients (polynomials, samples) of F between two ends in log(a/b).

    `torsion` gives F in rad·Nm/rad at ratios a/b (ratios, 1) in 1/Nm, as (ratios, samples).
    """

    def at(place: FloatArray) -> Any:  # of many samples at once, which NumPy's types leave out
        return torsion(np.exp(0.5 * (low + high + (high - low) * place))[:, None])

    found = chebyshev.chebinterpolate(at, _count(low, high) - 1)
    return np.ascontiguousarray(found, dtype=np.float64)
