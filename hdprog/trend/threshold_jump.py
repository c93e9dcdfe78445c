"""From a threshold of the teeth to another, or to none, and back.

Whether a loop's teeth have a threshold small against its readings' torques, or none at all, it
often leaves open: either way the compliance above is the same, a of the teeth as well, and b makes
up for what the threshold adds to their stiffness. Between the two the posterior may be low, for the
small threshold's own bend of the loop is worse in other places; and where T_T is all but none it is
flat over many spreads. A jump takes T_T somewhere else and keeps a and a·T_T + b.
"""

from __future__ import annotations

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.ridge_map import RidgeMap, onto_ridges
from hdprog.trend.wear_coordinates import mesh_threshold

_a, _b, _T_T = (NAMES.index(name) for name in ("a", "b", "T_T"))
_SAME = 1e-6  # within which a state's tangent leads back to it


def jumped(ridge: RidgeMap, states: FloatArray, by: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Jump in one test's threshold.

    Parameters
    ----------
    ridge : of the loop
    states : (draws, n) on its tangent
    by : (draws,) by how much the wear coordinate of T_T changes

    Returns
    -------
    (draws, n) on the tangent, and (draws,) log of the volume there over that before; −inf, and the
    state itself, where there is none to jump to
    """
    met, slope = _onto(ridge, states)
    other = met.copy()
    other[:, _T_T] += by
    before, after = (mesh_threshold(one, ridge.softplus_scale) for one in (met, other))
    with np.errstate(all="ignore"):
        other[:, _b] = np.log(np.exp(met[:, _b]) + np.exp(met[:, _a]) * (before - after))
        tangents = ridge.tangents_of(other)
        back, other_slope = _onto(ridge, tangents)
        # log b is the only coordinate that the jump stretches.
        volume = met[:, _b] - other[:, _b] + slope - other_slope
        there = np.isfinite(volume) & (np.abs(back - other).max(axis=1) < _SAME)
    return np.where(there[:, None], tangents, states), np.where(there, volume, -np.inf)


def _onto(ridge: RidgeMap, states: FloatArray) -> tuple[FloatArray, FloatArray]:
    met, slope = onto_ridges([ridge], states[:, None])
    return met[:, 0], slope[:, 0]
