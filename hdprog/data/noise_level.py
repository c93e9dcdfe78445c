"""How noisy and how coarse a recorded channel is, from the record alone."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["channel_noise", "noise_sd", "quantisation_step"]

_SD_PER_MEDIAN = 1.482602218505602  # of |x| for a normal x: 1 / Φ⁻¹(3/4)
_LONGEST_WINDOW = 51
_FEWEST_MOVES = 100


def quantisation_step(values: NDArray[np.float64]) -> float | None:
    """Find the step of the grid that the values lie on.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One channel, in any unit.

    Returns
    -------
    float or None
        The step in the channel's unit, None where the values lie on no grid, and where they
        move by the same number of steps from sample to sample, as an evenly sampled ramp does.
    """
    levels = np.unique(values)
    if levels.size < 3:
        return None
    gaps = np.diff(levels)
    # Conversion between units leaves rounding that would pass for levels of its own.
    gaps = gaps[gaps > 1e-9 * np.abs(levels).max()]
    if gaps.size < 2:
        return None
    step = float(gaps.min())
    multiples = gaps / step
    whole = np.abs(multiples - np.round(multiples)) < 0.02 * np.sqrt(multiples)
    # Where no gap is small against the rest, whole multiples would be an accident of few values.
    if whole.mean() < 0.98 or np.median(multiples) > 20:
        return None
    if not _moves_like_quantised(np.round(np.abs(np.diff(values)) / step)):
        return None
    return float(np.median(gaps[multiples < 1.5]))


def _moves_like_quantised(moves: NDArray[np.float64]) -> bool:
    """Tell resolution from even sampling by the whole steps between neighbouring samples."""
    moving = moves[moves > 0]
    # Coarse values stay, move, and stay again; a hold stays only once.
    stays = np.count_nonzero((moves[1:] > 0) & (moves[:-1] == 0))
    if stays >= 0.2 * moving.size:
        return True
    # Fine ones move now by so many steps and now by one more.
    switches = np.count_nonzero(moving[1:] != moving[:-1])
    return moving.size >= _FEWEST_MOVES and bool(switches >= 0.1 * moving.size)


def noise_sd(values: NDArray[np.float64]) -> float:
    """Estimate the standard deviation of a channel's noise about its own smooth course.

    The course is a cubic fitted to a short sliding window (Savitzky-Golay); the median of the
    distances from it is not moved by reversals, jumps or isolated spikes.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One channel in the order of recording.

    Returns
    -------
    float
        In the channel's unit; 0 for fewer than seven samples.
    """
    from scipy.signal import savgol_coeffs

    size = values.size
    if size < 7:
        return 0.0
    window = min(_LONGEST_WINDOW, max(5, size // 100)) | 1
    weights = -savgol_coeffs(window, 3)
    weights[window // 2] += 1.0
    # Distances of white noise from the fit are smaller than the noise by this factor.
    shrink = math.sqrt(float(weights @ weights))
    distances = np.abs(np.convolve(values, weights, mode="valid"))
    return float(np.median(distances)) * _SD_PER_MEDIAN / shrink


def channel_noise(values: NDArray[np.float64]) -> float:
    """Return the standard deviation of a channel's error, of noise and quantisation together.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One channel in the order of recording.

    Returns
    -------
    float
        In the channel's unit. A step q adds q/√12 where the noise does not already show it.
    """
    step = quantisation_step(values)
    return max(noise_sd(values), (step or 0.0) / math.sqrt(12.0))
