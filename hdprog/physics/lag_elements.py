"""Elements that lag behind the torque: elastic-slip (Jenkins) elements and exponential ones.

Both have a state between −1 and 1 that follows the direction of torque. A Jenkins element (a spring
behind a Coulomb slider; Iwan, J. Appl. Mech. 33 (1966) 893) is carried along until its limit; an
exponential one (Dahl 1968) approaches it.
"""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

_MOST_OWN = 0.95
_NEWTON_STEPS = 5  # to the last digits of all up to there


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
    course: Course, length: FloatArray, initial: FloatArray, lag: FloatArray | float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """State of elements that approach their limit exponentially in torque travelled.

    Parameters
    ----------
    course : the record
    length : (draws, 1) torque in Nm within which the distance to the limit falls to 1/e
    initial : (draws, 1) state at the first sample, −1 to 1
    lag : (draws, 1) in Nm: the torque that carries an element is that of the course and `lag` times
        the element's state; 0 where the course's own torque carries it

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
        own = np.asarray(lag / length * np.abs(missing[:, None]))
        left = _left_of_lag(travel[start:end] / length, own)
        state[:, start:end] = sign - missing[:, None] * left
        current = sign - missing * _left_of_lag(turns[number] / length, own)[:, 0]
        ends[:, number] = current
    return state, ends


def _left_of_lag(travelled: FloatArray, own: FloatArray) -> FloatArray:
    """g = exp(−u − p(1 − g)), the part of a lag that is left.

    Parameters
    ----------
    travelled : (draws, n) u, torque of the course over the element's length
    own : (draws, 1) p ≥ 0, what the element adds to that torque in turning round over its length;
        from 1 on the course would run backwards, so that it is held below
    """
    without = np.exp(-travelled)
    if not own.any():
        return without
    own, left = np.minimum(own, _MOST_OWN), without
    for _ in range(_NEWTON_STEPS):
        found = without * np.exp(own * (left - 1.0))
        left = left - (left - found) / (1.0 - own * found)
    return left
