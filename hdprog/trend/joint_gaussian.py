"""All that the tests met as one Gaussian, for many draws of the hyperparameters at once.

The state-space model of `hdprog.trend.state_space` written out over the tests: mean and covariance
of x_1 … x_T, scatter and warmth included. The filter says the same step by step; written out, one
may move all tests together and knows at once how likely that is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray
from hdprog.trend.state_space import Steps


def joint_gaussian(
    steps: Steps, scatter: FloatArray, scales: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Mean and covariance of what all tests met.

    Parameters
    ----------
    steps : of every draw, along the tests
    scatter : (draws,) of remounting
    scales : (n,) its relative sizes

    Returns
    -------
    (draws, tests, n), and (draws, tests·n, tests·n)
    """
    tests, count = steps.wear.shape[1], scales.size
    draws, every = len(scatter), np.arange(tests)
    along = np.outer(steps.direction, steps.direction)
    wear, passed, settled = (
        _since_beginning(each, steps.begins) for each in (steps.wear, steps.passed, steps.settled)
    )
    lead, integral = _integrated_walk(steps.passed, steps.departure, steps.begins)
    own = _since_beginning(steps.own, steps.begins)
    shared = _since_beginning(steps.shared, steps.begins)

    early = np.minimum.outer(every, every)
    later = passed[:, np.maximum.outer(every, every)] - passed[:, early]
    turned = integral[:, early] + lead[:, early] * later + shared[:, early]
    turned += steps.running_in[1] * settled[:, :, None] * settled[:, None, :]
    loading_variance = np.broadcast_to(steps.loading_variance, (draws, count))
    alone = own[:, early] + steps.initial_variance
    alone += (wear[:, :, None] * wear[:, None, :])[..., None] * loading_variance[:, None, None, :]
    alone += _of_loading_walk(steps, wear)
    warming = steps.warming
    if warming is not None:
        warmth = np.outer(warming.warmth, warming.warmth)
        alone += warmth[..., None] * warming.variance
    alone[:, every, every] += ((scatter[:, None] * scales) ** 2)[:, None, :]
    covariance = turned[:, :, None, :, None] * along[:, None, :]
    covariance = np.ascontiguousarray(covariance)
    each = np.arange(count)
    covariance[:, :, each, :, each] += np.moveaxis(alone, -1, 0)
    if warming is not None:
        covariance[:, every, :, every] += warming.unknown_part[:, None]
    life = np.cumsum(steps.begins)
    covariance *= (life[:, None] == life)[:, None, :, None]

    mean = steps.initial_mean + wear[..., None] * steps.loading_mean[:, None, :]
    mean = mean + steps.running_in[0] * settled[..., None] * steps.direction
    if warming is not None:
        mean = mean + warming.warmth[:, None] * warming.mean
    return mean, covariance.reshape(draws, tests * count, tests * count)


def _of_loading_walk(steps: Steps, wear: FloatArray) -> FloatArray:
    """Covariance (draws, tests, tests, n) that the walks of the loadings add to each coordinate.

    `wear` (draws, tests) since the drive began.
    """
    every = np.arange(wear.shape[1])
    early, late = np.minimum.outer(every, every), np.maximum.outer(every, every)
    lead, integral = _integrated_walk(steps.wear[..., None], steps.loading_walk, steps.begins)
    later = wear[:, late] - wear[:, early]
    return np.asarray(integral[:, early] + lead[:, early] * later[..., None])


def _integrated_walk(
    gone: FloatArray, gained: FloatArray, begins: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Covariance of a walk with its integral, and variance of that, at the tests.

    Parameters
    ----------
    gone : (draws, tests) or (draws, tests, 1) increment of what the walk is integrated over
    gained : (draws, tests, ...) variance that the walk gains meanwhile
    begins : (tests,) where both begin at zero

    Returns
    -------
    as `gained`, each
    """
    rate, lead, integral = np.zeros((3, *gained.shape))
    for test in range(begins.size):
        by, more = gone[:, test], gained[:, test]
        rate[:, test], lead[:, test] = more, more * by / 2
        integral[:, test] = more * by**2 / 3
        if not begins[test]:
            before = test - 1
            integral[:, test] += integral[:, before] + 2 * by * lead[:, before]
            integral[:, test] += by**2 * rate[:, before]
            lead[:, test] += lead[:, before] + by * rate[:, before]
            rate[:, test] += rate[:, before]
    return lead, integral


def _since_beginning(increments: FloatArray, begins: NDArray[np.bool_]) -> FloatArray:
    """Sums (draws, tests, ...) of increments, from zero at each beginning of a drive."""
    total = np.cumsum(increments, axis=1)
    before = np.concatenate([np.zeros_like(total[:, :1]), total[:, :-1]], axis=1)
    first = np.maximum.accumulate(np.where(begins, np.arange(begins.size), 0))
    return np.asarray(total - before[:, first])
