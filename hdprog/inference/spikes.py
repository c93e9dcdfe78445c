"""Isolated spikes, found in the residual of a fit.

The readings' distances z from their neighbours, in units of the noise, are taken for a mixture of
a normal distribution and a few spikes of any size, log-uniform (density ∝ 1/|z|). The spikes'
share is what makes the distances most likely (empirical Bayes; Efron, Large-Scale Inference,
2010, ch. 5), and a reading is a spike where that is the likelier of the two. Where spikes are many
a reading need not stand out as far as where it is the only one; on a record of n readings without
any, one has to be so far out as happens by chance in about one record of a hundred.

An error of a sensor does not come back at the same torque, as the few readings within a drive's
play do at every passage: what stands out alike in other passes is kept.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.optimize import brentq
from scipy.special import pdtrc

from hdprog.data.noise_level import SD_PER_MEDIAN
from hdprog.physics.parameters import FloatArray

REMARKABLE_SHARE = 0.01
"""Share of readings set aside from which on a fit says so in words."""

_SIDE = 5  # readings before, and as many behind, that a reading is compared with
_SIZES = (3.0, 1000.0)  # of spikes in noise standard deviations
_MOST = 0.10  # of the readings: more are no isolated errors
_ON_EACH_SIDE = 0.5  # of its size: by how much a spike stands out from either side
_LONGEST = 2  # readings in a row that are still an isolated error
_CHANCE = 0.01  # that a longer row of them is one by chance
_LOCAL = 61  # readings over which the noise may differ
_ROUGHER = 1.4  # times the usual: from there on it does
_NEAR_REVERSAL = 2  # readings, where a corner that fell between two of them looks isolated
_UNLIKE_OTHERS = 3.0  # times what stands out at most corners: no corner's doing
_STEPS_ASIDE = 2.0  # of the torque between readings: what is no farther is at the same torque
_LIKE_SIZE = 3.0  # ratio of two sizes up to which they may be one effect's
_RECURS_BY_CHANCE = 0.03  # expected of a record's spikes: fewer, and it is no chance
_LOG_ROOT_TWO_PI = np.log(np.sqrt(2 * np.pi))


def spikes(
    residual: FloatArray,
    sd: FloatArray,
    turning_points: NDArray[np.intp],
    step: float,
    torque: FloatArray,
) -> NDArray[np.bool_]:
    """Isolated spikes in a residual: far outside what their neighbours show, on both sides.

    None are named where more than a tenth of the readings stand out. More than two in a row are
    part of the record's course, but for those that adjoin by chance where spikes are many; so are
    those that come back in other passes at the same torque, or at the opposite one the other way.

    Parameters
    ----------
    residual : (samples,) in rad
    sd : (samples,) noise expected of each reading in rad, up to a common factor
    turning_points : indices of the first reading, reversals and the last reading
    step : usual move of the angle between readings in rad; a corner hides no more than that
    torque : (samples,) in Nm
    """
    none = np.zeros(residual.size, dtype=bool)
    if residual.size < 4 * _SIDE:
        return none
    distance, alone = _from_neighbours(residual)
    out = distance / sd
    scale = SD_PER_MEDIAN * float(np.median(np.abs(out)))
    if scale == 0.0:
        return none
    size = np.abs(out) / np.maximum(scale, _rougher(np.abs(out), scale))
    found, share = _far_out(np.where(alone, size, 0.0))
    recurrent = _recurrent(found, np.sign(out) * size, torque, turning_points, share)
    inner = turning_points[1:-1]
    if inner.size:
        near = inner[:, None] + np.arange(-_NEAR_REVERSAL, _NEAR_REVERSAL + 1)
        near = np.clip(near, 0, residual.size - 1)
        height = np.abs(distance[near])
        usual = float(np.median(height.max(axis=1)))
        found[near] &= height > min(step, _UNLIKE_OTHERS * usual)
    longest = _LONGEST
    while residual.size * share ** (longest + 1) > _CHANCE:
        longest += 1
    for start, end in pairwise(np.flatnonzero(np.diff(found, prepend=False, append=False))):
        if found[start] and (end - start > longest or recurrent[start:end].any()):
            found[start:end] = False
    return found if found.mean() <= _MOST else none


def remark_on_spikes(out: NDArray[np.bool_]) -> str | None:
    """What to say of readings (samples,) set aside, where they are many."""
    share = float(out.mean())
    if share <= REMARKABLE_SHARE:
        return None
    return (
        f"{np.count_nonzero(out)} of {out.size} readings ({share:.1%}) stand out alone from their "
        "neighbours and were set aside as spikes: no figure rests on them. Look at the loop: if "
        "they are the drive's own doing and no fault of the sensors, this fit leaves that out."
    )


def _from_neighbours(values: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Distance of each reading (samples,) from the median of those about it; whether on its own.

    At a step or at the edge of a tooth one of the two sides lies where the reading does.
    """
    padded = np.pad(values, _SIDE, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _SIDE + 1)
    before, behind = windows[:, :_SIDE], windows[:, _SIDE + 1 :]
    out = values - np.median(np.hstack([before, behind]), axis=1)
    sides = np.stack([values - np.median(side, axis=1) for side in (before, behind)])
    alone = np.all(np.sign(out) * sides > _ON_EACH_SIDE * np.abs(out), axis=0)
    return out, np.asarray(alone)


def _recurrent(
    found: NDArray[np.bool_],
    size: FloatArray,
    torque: FloatArray,
    turning_points: NDArray[np.intp],
    share: float,
) -> NDArray[np.bool_]:
    """(samples,) which of those found stand out alike in more other passes than chance allows.

    Parameters
    ----------
    found : (samples,) far outside what their neighbours show
    size : (samples,) by how much, with its sign
    torque, turning_points : see `spikes`
    share : of spikes among the readings
    """
    recurrent = np.zeros(found.size, dtype=bool)
    steps = np.abs(np.diff(torque))
    events = np.flatnonzero(found)
    if events.size < 2 or not steps.any():
        return recurrent
    rows = 1 + np.count_nonzero(np.diff(events) > 1)
    near = _STEPS_ASIDE * float(np.median(steps[steps > 0.0]))
    own = np.searchsorted(turning_points[1:-1], np.arange(found.size))
    low, high = _SIZES
    alike = 0.5 * min(2.0 * np.log(_LIKE_SIZE) / np.log(high / low), 1.0)
    for at in events:
        elsewhere = own != own[at]
        same = elsewhere & (np.abs(torque - torque[at]) <= near)
        opposite = elsewhere & (np.abs(torque + torque[at]) <= near)
        expected = share * alike * (np.count_nonzero(same) + np.count_nonzero(opposite))
        # Which of the others is as large, and of which sign.
        others = events[(same | opposite)[events]]
        ratio = size[others] / size[at]
        fits = np.where(ratio > 0.0, same[others], opposite[others])
        hits = fits & (np.abs(np.log(np.abs(ratio))) < np.log(_LIKE_SIZE))
        passes = np.unique(own[others[hits]]).size
        by_chance = rows * float(pdtrc(passes - 1, expected)) if passes else np.inf
        recurrent[at] = by_chance < _RECURS_BY_CHANCE
    return recurrent


def _rougher(size: FloatArray, scale: float) -> FloatArray:
    """(samples,) the noise's local scale where it is clearly above the usual one, else 0."""
    local = SD_PER_MEDIAN * median_filter(size, size=_LOCAL, mode="mirror")
    return np.where(local > _ROUGHER * scale, local, 0.0)


def _far_out(size: FloatArray) -> tuple[NDArray[np.bool_], float]:
    """Which of the distances (samples,) are spikes' rather than noise, and the spikes' share."""
    low, high = _SIZES
    ratio = np.zeros(size.size)
    possible = (size >= low) & (size <= high)
    log_spike = -np.log(size[possible] * np.log(high / low))
    log_noise = np.log(2.0) + (-(size[possible] ** 2) / 2.0 - _LOG_ROOT_TWO_PI)
    ratio[possible] = np.exp(np.minimum(log_spike - log_noise, 700.0))
    ratio[size > high] = np.inf
    beyond = np.clip(ratio, None, 1e12) - 1.0

    def slope(share: float) -> float:
        return float(np.sum(beyond / (1.0 + share * beyond)))

    if slope(0.0) <= 0.0:
        return np.zeros(size.size, dtype=bool), 0.0
    share = float(brentq(slope, 0.0, 1.0 - 1e-9))
    return share * ratio > 1.0 - share, share
