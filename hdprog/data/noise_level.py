"""How noisy and how coarse a recorded channel is, from the record alone."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["SD_PER_MEDIAN", "channel_noise", "error_sd", "noise_sd", "quantisation_step"]

SD_PER_MEDIAN = 1.482602218505602
"""Standard deviation of a normal x over the median of |x|: 1/Φ⁻¹(3/4)."""
_LONGEST_WINDOW = 51
_OF_A_PASSAGE = 10  # windows, at least, on a channel's way from its low to its high values
_FEWEST_MOVES = 100
_SEEN = 0.1  # of the noise: jitter that moves samples by less need not be looked at
_MOST_WINDOWS = 5_000  # the median of so many distances is known to 2 %


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


def noise_sd(values: NDArray[np.float64], time: NDArray[np.float64] | None = None) -> float:
    """Estimate the standard deviation of a channel's noise about its own smooth course.

    The course is a cubic fitted to a short sliding window (Savitzky-Golay); the median of the
    distances from it is not moved by reversals, jumps or isolated spikes. Samples at uneven times
    lie on no smooth course over their index, so that the course over time is tried as well: the
    smaller distance holds, as stamps can be wrong where the sampling was even.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One channel in the order of recording.
    time : ndarray, shape (n,), or None
        Increasing times of the samples, in any unit.

    Returns
    -------
    float
        In the channel's unit; 0 for fewer than seven samples.
    """
    size = values.size
    if size < 7:
        return 0.0
    # In a record of many cycles most windows of that length hold a turn, which is no noise.
    share = max(100, _OF_A_PASSAGE * (_passages(values) + 1))
    window = min(_LONGEST_WINDOW, max(5, size // share)) | 1
    weights = -_smoothing(window)
    weights[window // 2] += 1.0
    # Distances of white noise from the fit are smaller than the noise by this factor.
    shrink = math.sqrt(float(weights @ weights))
    distances = np.abs(np.convolve(values, weights, mode="valid")) / shrink
    noise = float(np.median(distances)) * SD_PER_MEDIAN
    if time is not None and _blurred(values, time, window) > _SEEN * noise:
        over_time = _distances_over_time(values, time, window)
        return min(noise, float(np.median(over_time)) * SD_PER_MEDIAN)
    return noise


def _passages(values: NDArray[np.float64]) -> int:
    """How often a channel goes from its low to its high values or back; spikes do not count."""
    low, high = np.quantile(values, (0.01, 0.99))
    quarter = 0.25 * (high - low)
    level = np.where(values > high - quarter, 1, np.where(values < low + quarter, -1, 0))
    return int(np.count_nonzero(np.diff(level[level != 0])))


def _smoothing(window: int) -> NDArray[np.float64]:
    """Weights (window,) of the cubic's value in the middle of so many readings (Savitzky & Golay).

    Those of scipy.signal.savgol_coeffs(window, 3), which half a second of imports come with.
    """
    from scipy.linalg import lstsq

    offset = np.arange(window // 2, -(window // 2) - 1, -1, dtype=float)
    weights, _, _, _ = lstsq(offset ** np.arange(4)[:, None], np.eye(4)[0])
    return np.asarray(weights)


def _blurred(values: NDArray[np.float64], time: NDArray[np.float64], window: int) -> float:
    """How far uneven sampling moves a channel's samples from its course over their index."""
    intervals = np.diff(time)
    jitter = np.median(np.abs(np.diff(intervals))) / np.median(intervals)
    return float(jitter * np.median(np.abs(values[window:] - values[:-window]))) / window


def _distances_over_time(
    values: NDArray[np.float64], time: NDArray[np.float64], window: int
) -> NDArray[np.float64]:
    """Distances of samples from the cubic over time of their window, in units of their noise.

    Parameters
    ----------
    values, time : ndarray, shape (n,)
        A channel and the times of its samples.
    window : int
        Odd number of samples of a window, at least 5.

    Returns
    -------
    ndarray, shape (windows,)
        Sizes, divided by what the fit leaves of white noise of variance 1.
    """
    last = values.size - window
    first = np.unique(np.linspace(0, last, min(last + 1, _MOST_WINDOWS)).astype(np.intp))
    at = first[:, None] + np.arange(window)
    middle = window // 2
    offset = time[at] - time[at[:, [middle]]]
    offset /= np.maximum(np.abs(offset).max(axis=1, keepdims=True), np.finfo(float).tiny)
    powers = offset[:, :, None] ** np.arange(4)
    basis = np.linalg.qr(powers)[0]
    # Row of the projection on what the cubic leaves; its squared norm is the variance left.
    weights = -np.einsum("wij,wj->wi", basis, basis[:, middle])
    weights[:, middle] += 1.0
    left = np.sqrt(np.maximum(np.einsum("wi,wi->w", weights, weights), 1e-12))
    shifted = values[at] - values[at[:, [middle]]]
    return np.asarray(np.abs(np.einsum("wi,wi->w", weights, shifted)) / left)


def channel_noise(values: NDArray[np.float64], time: NDArray[np.float64] | None = None) -> float:
    """Return the standard deviation of a channel's error, of noise and quantisation together.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One channel in the order of recording.
    time : ndarray, shape (n,), or None
        Increasing times of the samples, where they are known.

    Returns
    -------
    float
        In the channel's unit. A step q adds q/√12 where the noise does not already show it.
    """
    return error_sd(noise_sd(values, time), quantisation_step(values))


def error_sd(noise: float, step: float | None) -> float:
    """Return the standard deviation of noise and quantisation together; see `channel_noise`."""
    return max(noise, (step or 0.0) / math.sqrt(12.0))
