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


def follow_two(
    course: Course, driven_by: FloatArray, constant: FloatArray, doublings: int
) -> tuple[FloatArray, FloatArray]:
    """Mean of two followers of one course, and how what the slow one was left with fades.

    As two calls of `follow`, in two thirds of the time.

    Parameters
    ----------
    course : with time
    driven_by : (draws, samples) or (1, samples) u
    constant : (draws, 1) τ of the quick one in s
    doublings : of τ, to that of the slow one

    Returns
    -------
    mean of the followers, and exp(−t/τ) of the slow one, (draws, samples) each
    """
    assert course.time is not None
    quick, ratio = resolved(course, constant), 2**doublings
    rate = np.diff(driven_by, axis=1) / np.diff(course.time)
    slow_growth = np.exp(course.time / (ratio * quick))
    quick_growth = np.square(slow_growth)
    for _ in range(doublings - 1):
        np.square(quick_growth, out=quick_growth)
    # A sum waits for the one before it: as a complex number both followers share the waiting.
    behind = np.empty((len(quick), course.time.size - 1), dtype=np.complex128)
    np.multiply(np.diff(quick_growth, axis=1), rate, out=behind.real)
    np.multiply(np.diff(slow_growth, axis=1), ratio * rate, out=behind.imag)
    np.cumsum(behind, axis=1, out=behind)
    both = behind.real / quick_growth[:, 1:]
    both += behind.imag / slow_growth[:, 1:]
    both *= -0.5 * quick
    mean = np.empty_like(slow_growth)
    mean[:, 0] = driven_by[:, 0]
    np.add(driven_by[:, 1:], both, out=mean[:, 1:])
    return mean, np.reciprocal(slow_growth, out=slow_growth)


def resolved(course: Course, constant: FloatArray) -> FloatArray:
    """A time constant, but no shorter than a record can resolve."""
    assert course.scales.duration is not None
    return np.maximum(constant, _SHORTEST * course.scales.duration)
