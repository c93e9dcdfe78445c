"""Noise of a record's readings and spikes in it, found from the record itself."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from hdprog.config import NoiseResolution
from hdprog.data.loop import Loop
from hdprog.data.noise_level import channel_noise, noise_sd
from hdprog.data.reduce import ReducedLoop
from hdprog.physics.parameters import FloatArray

_SPIKE = 6.0  # noise standard deviations: a Gaussian reading in 5e8 is that far out
_MOST_SPIKES = 0.10
_NEIGHBOURS = 11
_LONGEST = 2  # readings in a row that are still an isolated error
_ROUNDING = 1e-9  # of the span: a simulated record without noise still has rounding


def reading_noise(loop: Loop, resolution: NoiseResolution) -> tuple[float, float]:
    """Standard deviation of a torque and of an angle reading about a smooth course.

    The larger of what the declared resolution implies (step/√12) and of what the record shows.

    Returns
    -------
    torque noise in Nm, angle noise in rad
    """
    torque, angle = channel_noise(loop.torque), channel_noise(loop.angle)
    if resolution.torque_Nm is not None:
        torque = max(torque, resolution.torque_Nm / np.sqrt(12))
    if resolution.angle_rad is not None:
        angle = max(angle, resolution.angle_rad / np.sqrt(12))
    return torque, max(angle, _ROUNDING * float(np.ptp(loop.angle)))


def block_noise(
    reduced: ReducedLoop, slope: FloatArray, torque_noise: float, angle_noise: float
) -> FloatArray:
    """(blocks,) relative standard deviation of the blocks' angles in rad.

    A torque error e moves the angle by slope·e, so a reading's variance is
    σ_θ² + (dΔθ/dT)²·σ_T²; a block averages its readings.

    Parameters
    ----------
    slope : (blocks,) dΔθ/dT in rad/Nm
    """
    return np.sqrt((angle_noise**2 + (slope * torque_noise) ** 2) / reduced.count)


def local_slope(torque: FloatArray, angle: FloatArray) -> FloatArray:
    """(blocks,) size of dΔθ/dT along a course in rad/Nm, from each block's neighbours."""
    rise = np.abs(np.gradient(angle))
    run = np.abs(np.gradient(torque))
    overall = np.ptp(angle) / np.ptp(torque)
    steep = rise / np.maximum(run, 1e-3 * np.ptp(torque) / torque.size)
    # At a reversal both neighbours lie on the same side: the slope there is a guess at best.
    return np.asarray(median_filter(np.clip(steep, 0.1 * overall, 10 * overall), size=5))


def spikes(residual: FloatArray) -> NDArray[np.bool_]:
    """Isolated spikes in a residual (samples,): far outside what their neighbours show.

    None are named where more than a tenth of the readings stand out, nor where more than two in a
    row do: that is no isolated error but part of the record's course.
    """
    standing_out = residual - median_filter(residual, size=_NEIGHBOURS)
    noise = noise_sd(residual)
    if noise == 0.0:
        return np.zeros(residual.size, dtype=bool)
    found = np.abs(standing_out) > _SPIKE * noise
    for start, end in pairwise(np.flatnonzero(np.diff(found, prepend=False, append=False))):
        if found[start] and end - start > _LONGEST:
            found[start:end] = False
    return found if found.mean() <= _MOST_SPIKES else np.zeros(residual.size, dtype=bool)
