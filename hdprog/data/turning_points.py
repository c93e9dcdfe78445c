"""Where the torque turns: reversals told from noise by a zigzag with hysteresis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hdprog.data.noise_level import channel_noise
from hdprog.data.reversal_sides import last_before_reversal

__all__ = ["smallest_swing", "turning_points"]

_NOISE_SDS = 8.0
_SHARE_OF_SPAN = 0.01
_LONGEST_HALF_WINDOW = 25


def smallest_swing(torque: NDArray[np.float64], time: NDArray[np.float64] | None = None) -> float:
    """Return the change of torque [Nm] that counts as a swing and not as noise.

    Eight standard deviations of the torque's noise (quantisation included) and at least 1 % of
    the torque's span. Times of the samples, where known, tell uneven sampling from noise.
    """
    return _swing(torque, channel_noise(torque, time))


def _swing(torque: NDArray[np.float64], noise: float) -> float:
    return max(_NOISE_SDS * noise, _SHARE_OF_SPAN * float(np.ptp(torque)))


def turning_points(
    torque: NDArray[np.float64],
    min_swing: float | None = None,
    time: NDArray[np.float64] | None = None,
) -> NDArray[np.intp]:
    """Find the samples at which the torque turns.

    Parameters
    ----------
    torque : ndarray, shape (n,)
        Torque [Nm] in the order of recording, n ≥ 1.
    min_swing : float or None
        Smallest change of torque [Nm] that counts as a swing; None takes `smallest_swing`.
    time : ndarray, shape (n,), or None
        Increasing times of the samples, where they are known.

    Returns
    -------
    ndarray of int, shape (k,)
        Increasing indices: the first sample, the last before each reversal, the last sample.
        Between two of them the torque changes by at least `min_swing`; where branches are longer
        than 80 samples, its mean over some neighbours does (at most 25 on either side). Holds and
        isolated spikes add none; a hold belongs to what went before it.
    """
    torque = np.asarray(torque, dtype=np.float64)
    last = torque.size - 1
    if last < 1:
        return np.zeros(min(torque.size, 1), dtype=np.intp)
    noise = channel_noise(torque, time)
    swing = _swing(torque, noise) if min_swing is None else float(min_swing)
    clean = _without_spikes(torque, swing)
    half = _half_window(clean)
    means = _moving_mean(clean, half)
    extremes = _sharpened(clean, means, _extremes(means, swing), half)
    inner = last_before_reversal(clean, extremes[(extremes > 0) & (extremes < last)], noise)
    return np.concatenate(([0], inner, [last])).astype(np.intp)


def _without_spikes(torque: NDArray[np.float64], swing: float) -> NDArray[np.float64]:
    """Level single samples that stand out from both neighbours by far more than these move."""
    if torque.size < 5:
        return torque
    steps = np.diff(torque)
    into, out_of = steps[1:-2], -steps[2:-1]
    stands_out = np.where(np.sign(into) == np.sign(out_of), np.minimum(abs(into), abs(out_of)), 0)
    usual = np.maximum(abs(steps[:-3]), abs(steps[3:]))
    spikes = np.flatnonzero(stands_out > swing + 3.0 * usual) + 2
    if spikes.size == 0:
        return torque
    levelled = torque.copy()
    levelled[spikes] = 0.5 * (torque[spikes - 1] + torque[spikes + 1])
    return levelled


def _half_window(torque: NDArray[np.float64]) -> int:
    """Return a number of samples that is short against a loading or an unloading.

    Torque from a motor's current hunts where a drive passes through its play, by far more than
    its noise elsewhere, but within a few samples.
    """
    branches = len(_extremes(torque, 0.5 * float(np.ptp(torque)))) + 1
    return min(_LONGEST_HALF_WINDOW, torque.size // (80 * branches))


def _moving_mean(torque: NDArray[np.float64], half: int) -> NDArray[np.float64]:
    """Return the mean over `half` samples on either side, over fewer near the two ends."""
    if half == 0:
        return torque
    sums = np.concatenate(([0.0], np.cumsum(torque)))
    index = np.arange(torque.size)
    reach = np.minimum(half, np.minimum(index, torque.size - 1 - index))
    means: NDArray[np.float64] = (sums[index + reach + 1] - sums[index - reach]) / (2 * reach + 1)
    return means


def _sharpened(
    torque: NDArray[np.float64], means: NDArray[np.float64], extremes: list[int], half: int
) -> NDArray[np.intp]:
    """Move each extreme of the mean to that of the torque near it; on a plateau, to its end."""
    found = np.array(extremes, dtype=np.intp)
    if found.size == 0:
        return found
    borders = np.concatenate(([0], (found[1:] + found[:-1] + 1) // 2, [torque.size]))
    peaks = np.diff(means[found], prepend=torque[0]) > 0
    for number, index in enumerate(extremes):
        start = max(index - half, int(borders[number]))
        near = torque[start : min(index + half + 1, int(borders[number + 1]))]
        found[number] = start + int(np.argmax(near) if peaks[number] else np.argmin(near))
    last_of_plateau = np.append(np.flatnonzero(np.diff(torque)), torque.size - 1)
    ends: NDArray[np.intp] = last_of_plateau[np.searchsorted(last_of_plateau, found)]
    return ends


def _local_extremes(torque: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the first and last sample and each at which the direction changes."""
    moves = np.flatnonzero(np.diff(torque))
    if moves.size == 0:
        return np.array([0], dtype=np.intp)
    rising = torque[moves + 1] > torque[moves]
    # The sample before a move in a new direction; on a plateau that is its last sample.
    turns = moves[1:][rising[1:] != rising[:-1]]
    return np.concatenate(([0], turns, [torque.size - 1])).astype(np.intp)


def _extremes(torque: NDArray[np.float64], swing: float) -> list[int]:
    """Return the confirmed extremes: each is followed by a move back of at least `swing`."""
    candidates = _local_extremes(torque)
    extremes: list[int] = []
    highest = lowest = 0
    highest_value = lowest_value = float(torque[0])
    direction = 0  # unknown until the torque has moved by a whole swing
    for index, value in zip(candidates.tolist(), torque[candidates].tolist(), strict=True):
        if value > highest_value:
            highest, highest_value = index, value
        if value < lowest_value:
            lowest, lowest_value = index, value
        if direction >= 0 and highest_value - value >= swing and highest_value > value:
            if direction > 0:
                extremes.append(highest)
            direction, lowest, lowest_value = -1, index, value
        elif direction <= 0 and value - lowest_value >= swing and value > lowest_value:
            if direction < 0:
                extremes.append(lowest)
            direction, highest, highest_value = 1, index, value
    return extremes
