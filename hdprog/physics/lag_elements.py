"""Elements that lag behind the torque: elastic-slip (Jenkins) elements and exponential ones.

Both have a state between −1 and 1 that follows the direction of torque. A Jenkins element (a spring
behind a Coulomb slider; Iwan, J. Appl. Mech. 33 (1966) 893) is carried along until its limit; an
exponential one (Dahl 1968) approaches it.
"""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray


def jenkins(course: Course, limit: FloatArray, initial: FloatArray) -> FloatArray:
    """State of Jenkins elements along a course.

    Parameters
    ----------
    course : the record
    limit : (draws, 1) torque in Nm that carries an element from its middle to its limit
    initial : (draws, 1) state at the first sample, −1 to 1

    Returns
    -------
    (draws, samples), −1 to 1
    """
    path, turns = course.path, course.spans / limit
    state = course.travel / limit
    current = initial[:, 0]
    for number, (start, end) in enumerate(zip(path.starts, path.ends, strict=True)):
        sign = 1.0 if path.rising[number] else -1.0
        carried = state[:, start:end]
        carried += sign * current[:, None]
        np.minimum(carried, 1.0, out=carried)
        current = sign * np.minimum(sign * current + turns[:, number], 1.0)
    state *= path.direction
    return state


def exponential_lag(
    course: Course, length: FloatArray, initial: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """State of elements that approach their limit exponentially in torque travelled.

    Parameters
    ----------
    course : the record
    length : (draws, 1) torque in Nm within which the distance to the limit falls to 1/e
    initial : (draws, 1) state at the first sample, −1 to 1

    Returns
    -------
    (draws, samples) along the course and (draws, stretches) at the stretches' ends, −1 to 1
    """
    path, travel, turns = course.path, course.travel, course.spans
    state = np.empty((length.shape[0], travel.size))
    ends = np.empty((length.shape[0], turns.size))
    current = initial[:, 0]
    for number, (start, end) in enumerate(zip(path.starts, path.ends, strict=True)):
        sign = 1.0 if path.rising[number] else -1.0
        missing = sign - current
        state[:, start:end] = sign - missing[:, None] * np.exp(-travel[start:end] / length)
        current = sign - missing * np.exp(-turns[number] / length[:, 0])
        ends[:, number] = current
    return state, ends
