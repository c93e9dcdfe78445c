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
    rate = np.diff(driven_by, axis=1) / np.diff(course.time)
    # Over a step w·exp(t/τ) gains τ du/dt times what exp(t/τ) gains.
    growth = np.exp(course.time / constant)
    behind = np.diff(growth, axis=1) * rate
    np.cumsum(behind, axis=1, out=behind)
    behind /= growth[:, 1:]
    behind *= constant
    follower = np.empty((len(behind), course.time.size))
    follower[:, 0] = driven_by[:, 0]
    np.subtract(driven_by[:, 1:], behind, out=follower[:, 1:])
    return follower


def resolved(course: Course, constant: FloatArray) -> FloatArray:
    """A time constant, but no shorter than a record can resolve."""
    assert course.scales.duration is not None
    return np.maximum(constant, _SHORTEST * course.scales.duration)
