"""The coordinates of a record that a residual may follow."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

_MOVES = 1e-6


def coordinates(course: Course) -> Mapping[str, FloatArray]:
    """Every coordinate that a record has and that moves, by name, (samples,) each.

    torque [Nm]; branch [Nm], torque told apart by the direction of torque;
    distance_since_reversal [Nm] travelled; time [s] and time_since_reversal [s], or order [-] where
    the record is untimed; rate [Nm/s]; temperature [°C]; output_angle [rad].
    """
    torque = course.path.torque
    found: dict[str, FloatArray] = {
        "torque": torque,
        "branch": torque,
        "distance_since_reversal": course.travel,
    }
    if course.time is None:
        found["order"] = course.order
    else:
        found["time"] = course.time
        found["time_since_reversal"] = _since_reversal(course, course.time)
    others = {
        "rate": course.rate,
        "temperature": course.temperature,
        "output_angle": course.output_angle,
    }
    found.update({name: values for name, values in others.items() if values is not None})
    return {
        name: values
        for name, values in found.items()
        if np.ptp(values) > _MOVES * np.max(np.abs(values))
    }


def _since_reversal(course: Course, time: FloatArray) -> FloatArray:
    starts = course.path.starts
    last = time[np.maximum(starts - 1, 0)]
    return np.asarray(time - np.repeat(last, course.path.lengths))
