"""Density of the hour at which a limit is passed, smoothed from its distribution function."""

from __future__ import annotations

import math

import numpy as np

from hdprog.physics.parameters import FloatArray
from hdprog.results import Forecast

_POINTS = 400
_EFFECTIVE = 150.0
"""Draws that the smoothing takes the forecast to rest on: it hides steps, not the shape."""
_NEAREST, _NARROWEST = 1e-5, 0.01
"""Least hours from now, as a share of the horizon's; least width, as a share of the hours."""


def crossing_density(forecast: Forecast, hours: FloatArray) -> FloatArray:
    """Density of the first crossing, in 1/h.

    What has crossed by now is left out, what has not by the horizon, too: the area is what lies
    between.

    Parameters
    ----------
    forecast : with its distribution function
    hours : (n,) service hours

    Returns
    -------
    (n,), zero before now and past the horizon
    """
    table = forecast.crossing_probability
    start, end = float(table[0, 1]), float(table[-1, 1])
    inside = (hours >= table[0, 0]) & (hours <= table[-1, 0])
    if end - start <= 1e-6:
        return np.zeros_like(hours)
    levels = start + (end - start) * (np.arange(_POINTS) + 0.5) / _POINTS
    now, span = float(table[0, 0]), float(table[-1, 0] - table[0, 0])
    # Over the logarithm of the hours from now: nothing leaks to before now, and what comes soon is
    # not smeared by what may come late.
    ahead = np.maximum(hours - now, _NEAREST * span)
    at = np.log(np.maximum(np.interp(levels, table[:, 1], table[:, 0]) - now, _NEAREST * span))
    width = _bandwidth(at)
    # Mirrored at the horizon, past which nothing is drawn: what is smoothed past it comes back.
    at = np.concatenate([at, 2.0 * math.log(span) - at])
    distance = (np.log(ahead)[:, None] - at) / width
    hill = np.exp(-0.5 * distance**2).sum(axis=1) / (_POINTS * width * math.sqrt(2 * math.pi))
    return np.asarray(np.where(inside, (end - start) * hill / ahead, 0.0))


def _bandwidth(at: FloatArray) -> float:
    low, high = np.quantile(at, [0.25, 0.75])
    spread = min(float(at.std()), float(high - low) / 1.34) or float(at.std())
    return float(max(1.06 * spread * _EFFECTIVE**-0.2, _NARROWEST))
