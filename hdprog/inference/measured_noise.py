"""Noise of a record's readings, found from the record itself."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from hdprog.config import NoiseResolution
from hdprog.data.loop import Loop
from hdprog.data.noise_level import error_sd, noise_sd, quantisation_step
from hdprog.data.reduce import ReducedLoop
from hdprog.physics.parameters import FloatArray

_ROUNDING = 1e-9  # of the span: a simulated record without noise still has rounding


def reading_noise(loop: Loop, resolution: NoiseResolution) -> tuple[float, float]:
    """Standard deviation of a torque and of an angle reading about a smooth course.

    The larger of what the resolution implies (see `rounding_noise`) and of what the record shows.

    Returns
    -------
    torque noise in Nm, angle noise in rad
    """
    torque, angle = rounding_noise(loop, resolution)
    return max(torque, loop.torque_scatter), max(angle, loop.angle_scatter)


def rounding_noise(loop: Loop, resolution: NoiseResolution) -> tuple[float, float]:
    """The least noise of a torque and of an angle reading: step/√12, of a declared or its own step.

    Returns
    -------
    torque noise in Nm, angle noise in rad
    """
    torque = error_sd(0.0, quantisation_step(loop.torque))
    angle = error_sd(0.0, quantisation_step(loop.angle))
    if resolution.torque_Nm is not None:
        torque = max(torque, resolution.torque_Nm / np.sqrt(12))
    if resolution.angle_rad is not None:
        angle = max(angle, resolution.angle_rad / np.sqrt(12))
    return torque, max(angle, _ROUNDING * float(np.ptp(loop.angle)))


def noise_floor(
    residual: FloatArray,
    time: FloatArray | None,
    slope: FloatArray,
    noise: tuple[float, float],
    rounding: tuple[float, float],
) -> float:
    """Scatter in rad of neighbouring residuals about a smooth course, in which torque noise counts.

    At most what the two channels scatter by each for itself, for they may do so together, where
    the output moves; at least what rounding leaves, of which neighbours may have the same.

    Parameters
    ----------
    residual, time, slope : (readings,) in rad, in s or None, and dΔθ/dT in rad/Nm
    noise, rounding : of a torque and an angle reading, see `reading_noise`, `rounding_noise`
    """
    sd = reading_sd(slope, *noise)
    least, most = (float(np.sqrt(np.mean(each**2))) for each in (reading_sd(slope, *rounding), sd))
    # In units of their own noise, as a median knows nothing of the few that scatter by more.
    return min(max(most * noise_sd(residual / sd, time), least), most)


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
    return reading_sd(slope, torque_noise, angle_noise) / np.sqrt(reduced.count)


def reading_sd(slope: FloatArray, torque_noise: float, angle_noise: float) -> FloatArray:
    """Standard deviation of single readings' angles in rad, where dΔθ/dT is `slope` (...)."""
    return np.asarray(np.hypot(angle_noise, slope * torque_noise))


def local_slope(torque: FloatArray, angle: FloatArray) -> FloatArray:
    """(blocks,) size of dΔθ/dT along a course in rad/Nm, from each block's neighbours."""
    rise = np.abs(np.gradient(angle))
    run = np.abs(np.gradient(torque))
    overall = np.ptp(angle) / np.ptp(torque)
    steep = rise / np.maximum(run, 1e-3 * np.ptp(torque) / torque.size)
    # At a reversal both neighbours lie on the same side: the slope there is a guess at best.
    return np.asarray(median_filter(np.clip(steep, 0.1 * overall, 10 * overall), size=5))
