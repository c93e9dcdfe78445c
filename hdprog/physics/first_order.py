"""First-order followers along a timed course."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

_SHORTEST = 1 / 400  # of the record: quicker followers cannot be told from what they follow


def follow(course: Course, driven_by: FloatArray, constant: FloatArray) -> FloatArray:
    """Follower x of a driving course u, τ dx/dt = u − x, in balance at the first sample.

    x = u − w with τ dw/dt = τ du/dt − w is solved exactly for u that is linear in time between the
    samples.

    Parameters
    ----------
    course : with time
    driven_by : (draws, samples) or (1, samples) u
    constant : (draws, 1) τ in s

    Returns
    -------
    (draws, samples)
    """
    assert course.time is not None
    constant = resolved(course, constant)
    step = np.diff(course.time)
    rate = np.diff(driven_by, axis=1) / step
    behind = rate * constant * -np.expm1(-step / constant)
    growth = np.exp(course.time / constant)
    summed = np.cumsum(behind * growth[:, 1:], axis=1)
    missing = np.concatenate([np.zeros_like(constant), summed / growth[:, 1:]], axis=1)
    return np.asarray(driven_by - missing)


def resolved(course: Course, constant: FloatArray) -> FloatArray:
    """A time constant, but no shorter than a record can resolve."""
    assert course.scales.duration is not None
    return np.maximum(constant, _SHORTEST * course.scales.duration)
