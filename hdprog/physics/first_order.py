"""First-order followers along a timed course."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

_SHORTEST = 1 / 6400  # of the record: quicker followers cannot be told from what they follow
_SHORTEST_OF_TWO = 1 / 400
_STRETCH = 400.0  # time constants in one stretch: their exponentials are numbers
_PAUSE = 250.0  # time constants between two readings that make a stretch of their own


def follow(
    course: Course,
    driven_by: FloatArray,
    constant: FloatArray,
    beginning: FloatArray | None = None,
) -> FloatArray:
    """Follower x of a driving course u, τ dx/dt = u − x.

    x = u − w with τ dw/dt = τ du/dt − w is solved exactly for u that is linear in time between the
    samples, stretch after stretch where the record is long.

    Parameters
    ----------
    course : with time
    driven_by : (draws, samples) or (1, samples) u
    constant : (draws, 1) τ in s
    beginning : (draws, 1) x at time zero, when u was as at the first sample; in balance if None

    Returns
    -------
    (draws, samples)
    """
    assert course.time is not None
    assert course.scales.duration is not None
    constant = resolved(course, constant)
    time, rate = course.time, np.diff(driven_by, axis=1) / np.diff(course.time)
    stretches = int(np.ceil(course.scales.duration / (_STRETCH * float(constant.min()))))
    inner = np.searchsorted(time, time[0] + np.ptp(time) * np.arange(1, stretches) / stretches)
    pauses = np.flatnonzero(np.diff(time) > _PAUSE * float(constant.min()))
    ends = np.unique([0, *inner, *pauses, *(pauses + 1), time.size - 1])
    follower = np.empty((max(len(driven_by), len(constant)), time.size))
    follower[:, :1] = driven_by[:, :1]
    left: FloatArray | None = None  # of w over τ at the stretch's beginning
    if beginning is not None:
        left = (driven_by[:, :1] - beginning) * np.exp(-time[0] / constant) / constant
        follower[:, :1] -= left * constant
    for start, end in pairwise(ends.tolist()):
        if end == start + 1:
            fading = np.exp(-(time[end] - time[start]) / constant)
            behind = rate[:, start:end] * (1.0 - fading)
            if left is not None:
                behind += left * fading
        else:
            since = time[start : end + 1] - (time[start] if start else 0.0)
            # Over a step w·exp(t/τ) gains τ du/dt times what exp(t/τ) gains.
            growth = np.exp(since / constant)
            behind = np.diff(growth, axis=1) * rate[:, start:end]
            if left is not None:
                behind[:, :1] += left * growth[:, :1]
            np.cumsum(behind, axis=1, out=behind)
            behind /= growth[:, 1:]
        left, behind = behind[:, -1:].copy(), behind * constant
        np.subtract(driven_by[:, start + 1 : end + 1], behind, out=follower[:, start + 1 : end + 1])
    return follower


def follow_two(
    course: Course,
    driven_by: FloatArray,
    constant: FloatArray,
    doublings: int,
    share: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Weighted mean of two followers of one course, and how what the slow one was left with fades.

    As two calls of `follow`, in two thirds of the time.

    Parameters
    ----------
    course : with time
    driven_by : (draws, samples) or (1, samples) u
    constant : (draws, 1) τ of the quick one in s
    doublings : of τ, to that of the slow one
    share : (draws, 1) weight of the quick one

    Returns
    -------
    mean of the followers, and exp(−t/τ) of the slow one, (draws, samples) each
    """
    assert course.time is not None
    quick, ratio = resolved(course, constant, _SHORTEST_OF_TWO), 2**doublings
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
    both *= share
    slow = behind.imag / slow_growth[:, 1:]
    slow *= 1.0 - share
    both += slow
    both *= -quick
    mean = np.empty_like(slow_growth)
    mean[:, 0] = driven_by[:, 0]
    np.add(driven_by[:, 1:], both, out=mean[:, 1:])
    return mean, np.reciprocal(slow_growth, out=slow_growth)


def resolved(course: Course, constant: FloatArray, shortest: float = _SHORTEST) -> FloatArray:
    """A time constant, but no shorter than a share of the record."""
    assert course.scales.duration is not None
    return np.maximum(constant, shortest * course.scales.duration)
