"""Coordinates of a record beside its torque: denoised loading rate, time, scales."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hdprog.data.loop import Loop
from hdprog.data.noise_level import channel_noise, quantisation_step
from hdprog.physics.course import Course, Scales
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath
from hdprog.physics.warm_up import WarmUp

_CERTAIN = 0.05  # share of a stretch's mean rate to which noise may blur the rate
_WIDEST = 1 / 4  # of a stretch
_SLOW = 40  # parts of the record over which a temperature is averaged


def record_course(loop: Loop, path: TorquePath, torque_noise: float) -> Course:
    """Every coordinate of a record at its own readings.

    Parameters
    ----------
    loop : the record
    path : its torque over all readings, split at the reversals
    torque_noise : standard deviation of a torque reading in Nm
    """
    count = len(loop)
    rate = None
    if loop.time is not None:
        rate = loading_rate(loop.torque, loop.time, path.starts, torque_noise)
    speed = None
    if loop.time is not None and loop.output_angle is not None:
        noise = channel_noise(loop.output_angle, loop.time)
        speed = loading_rate(loop.output_angle, loop.time, path.starts, noise)
    temperature = None if loop.temperature is None else denoised(loop.temperature)
    step = quantisation_step(loop.angle)
    order = np.linspace(0.0, 1.0, count)
    clock = order if loop.time is None else loop.time / loop.time[-1]
    return Course(
        path=path,
        order=order,
        time=loop.time,
        rate=rate,
        temperature=temperature,
        output_angle=loop.output_angle,
        scales=Scales(
            torque=float(np.max(np.abs(loop.torque))),
            angle=float(np.ptp(loop.angle)) / 2,
            rate=None if rate is None else float(np.quantile(np.abs(rate), 0.98)),
            duration=None if loop.time is None else float(loop.time[-1]),
            sweep=None if loop.output_angle is None else float(np.ptp(loop.output_angle)),
            readings=count,
            output_middle=None if loop.output_angle is None else float(loop.output_angle.mean()),
            warm_up=None if temperature is None else WarmUp.nearest(clock, temperature),
            angle_step=step,
            angle_error=None if step is None else channel_noise(loop.angle, loop.time),
        ),
        output_speed=speed,
    )


def denoised(values: FloatArray) -> FloatArray:
    """Mean of a slow channel (samples,) over a fortieth of the record about each reading."""
    half = values.size // (2 * _SLOW)
    index = np.arange(values.size)
    # As far to either side: at the ends nothing is drawn inwards.
    reach = np.minimum(half, np.minimum(index, index[::-1]))
    sums = np.concatenate([[0.0], np.cumsum(values - values[0])])
    mean = (sums[index + reach + 1] - sums[index - reach]) / (2 * reach + 1)
    return np.asarray(values[0] + mean)


def loading_rate(
    torque: FloatArray, time: FloatArray, starts: NDArray[np.intp], noise: float
) -> FloatArray:
    """Loading rate from straight lines fitted within a sliding part of each stretch.

    Serves the rate of any other channel too.
    Raw differences of a noisy torque have neither its direction nor its rate. A part holds as many
    readings as it takes to find a stretch's mean rate to 5 %.

    Parameters
    ----------
    torque, time : (samples,) in Nm and s, time increasing
    starts : (stretches,) first sample of each stretch
    noise : standard deviation of a torque reading in Nm

    Returns
    -------
    (samples,) dT/dt in Nm/s
    """
    rate = np.empty(torque.size)
    for start, end in pairwise([*starts.tolist(), torque.size]):
        size = end - start
        if size < 2:
            near = slice(max(0, start - 1), min(torque.size, end + 1))
            rate[start:end] = np.polyfit(time[near], torque[near], 1)[0] if size else 0.0
            continue
        x, y = time[start:end] - time[start:end].mean(), torque[start:end]
        half = _half_window(float(np.ptp(y)) / size, size, noise)
        index = np.arange(size)
        low = np.clip(index - half, 0, max(0, size - 2 * half - 1))
        high = np.minimum(low + 2 * half + 1, size)
        sums = np.cumsum(
            np.vstack([np.ones(size), x, y, x * x, x * y]), axis=1, dtype=np.longdouble
        )
        sums = np.hstack([np.zeros((5, 1), dtype=np.longdouble), sums])
        n, sx, sy, sxx, sxy = sums[:, high] - sums[:, low]
        rate[start:end] = (n * sxy - sx * sy) / (n * sxx - sx * sx)
    return rate


def _half_window(step: float, size: int, noise: float) -> int:
    """Readings on either side: a slope over m of them has the error √12·noise/m^1.5."""
    wanted = (np.sqrt(12) * noise / (_CERTAIN * max(step, 1e-12))) ** (2 / 3)
    return int(np.clip(np.ceil((wanted - 1) / 2), 1, max(1, _WIDEST * size / 2)))
