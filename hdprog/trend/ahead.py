"""Paths of a drive's state past its last test."""

from __future__ import annotations

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.kalman_filter import RATE, RUNNING_IN
from hdprog.trend.smoother import walked
from hdprog.trend.state_space import Steps
from hdprog.trend.wear_prior import RateAhead

_B = NAMES.index("b")
_SLOWEST = 0.02  # of the clock's rate: what a drive goes on with that seems to stand still
_FASTEST_LOG = 6.0  # four hundred times as fast is beyond any figure
_NO_FALL = 1e-9
_FARTHEST = 15.0  # prior spreads of a coordinate from its prior mean: figures stay finite


def simulate_ahead(
    steps: Steps,
    rng: np.random.Generator,
    start: tuple[FloatArray, FloatArray],
    first: int,
    ahead: RateAhead,
) -> FloatArray:
    """Draw states after the last test, where the rate of wear changes by factors.

    Seen from tests, the rate's departure is linear, so that a filter can follow it. Ahead it starts
    from where it is, 1 + v times the clock's, and changes by exp(W) with a random walk W: a rate
    does not run below zero, and one that has grown may grow on. W drifts upwards, as the last stage
    of wear is the one that speeds up; where the pace is steady, it stays so. Where the clock has
    levelled off, wear does not heal. Loadings walk on as before.

    Parameters
    ----------
    steps : of every draw
    rng : source of randomness
    start : state (draws, n) and carried (draws, n + 2) just before `first`
    first : first time to draw
    ahead : spread of W over that of the departure in the past, and its drift

    Returns
    -------
    states (draws, times − first, n)
    """
    draws, times = steps.wear.shape
    x, c = start
    rate = np.maximum(1.0 + c[:, RATE], _SLOWEST)
    walk, loadings = np.zeros(draws), c[:, : steps.size]
    states = np.empty((draws, times - first, steps.size))
    for time in range(first, times):
        wear, passed = steps.wear[:, time], steps.passed[:, time]
        common, turn, lead = rng.standard_normal((3, draws))
        departure = ahead.spread * np.sqrt(steps.departure[:, time])
        drift = np.where(departure > 0, ahead.drift * steps.lived[:, time], 0.0)
        meanwhile = walk + drift / 2 + departure * (turn / 2 + lead / np.sqrt(12))
        gained = passed * (rate * np.exp(np.minimum(meanwhile, _FASTEST_LOG)) - 1.0)
        gained = np.maximum(gained, -wear)
        gained = gained + np.sqrt(steps.shared[:, time]) * common
        gained = gained + steps.settled[:, time] * c[:, RUNNING_IN]
        own = np.sqrt(steps.own[:, time]) * rng.standard_normal((draws, steps.size))
        pace, loadings = walked(loadings, steps.loading_walk[:, time], rng)
        x = x + wear[:, None] * pace + gained[:, None] * steps.direction + own
        walk = walk + drift + departure * turn
        states[:, time - first] = x
    return states


def within_reach(steps: Steps, states: FloatArray) -> FloatArray:
    """States (..., n), held where figures stay finite."""
    farthest = _FARTHEST * np.sqrt(steps.initial_variance)
    return np.clip(states, steps.initial_mean - farthest, steps.initial_mean + farthest)


def worn_ahead(steps: Steps, now: FloatArray, ahead: FloatArray, floor: FloatArray) -> FloatArray:
    """States to come with an end to wear, held within reach; parameters as in `wear_out`.

    In this order: a parameter held at its bound would leave its share of the way to all others.
    """
    return within_reach(steps, wear_out(now, ahead, floor))


def wear_out(now: FloatArray, ahead: FloatArray, floor: FloatArray) -> FloatArray:
    """Let wear come to its end where the stiffness of the first teeth does.

    Where b would fall below its floor, it tends to it instead (see `level_off`), and everything
    else goes on from now by the same share of its way: a drive whose teeth are worn out does not
    lose preload or gain backlash as if they were not.

    Parameters
    ----------
    now : (draws, n) wear coordinates at present
    ahead : (draws, times, n) to come, without an end
    floor : (draws,) of b in Nm/rad, below its present value

    Returns
    -------
    (draws, times, n) to come
    """
    present = now[:, _B]
    fall = present[:, None] - ahead[..., _B]
    left = present[:, None] - level_off(present, ahead[..., _B], floor)
    share = np.where(fall > _NO_FALL, left / np.maximum(fall, _NO_FALL), 1.0)
    return np.asarray(now[:, None] + share[..., None] * (ahead - now[:, None]))


def level_off(now: FloatArray, ahead: FloatArray, floor: FloatArray) -> FloatArray:
    """Let the logarithm of a stiffness, where it falls, tend to its floor.

    With f the floor, b = f + (b_now − f)·exp(−fall/(1 − f/b_now)): the slope at now is kept.

    Parameters
    ----------
    now : (draws,) logarithm at present, of b in Nm/rad
    ahead : (draws, times) logarithm to come, without a floor
    floor : (draws,) in Nm/rad, below the present value

    Returns
    -------
    (draws, times) logarithm to come
    """
    share = np.minimum(floor / np.exp(now), 0.999)[:, None]
    fall = now[:, None] - ahead
    level = share + (1 - share) * np.exp(-np.maximum(fall, 0.0) / (1 - share))
    return np.asarray(np.where(fall > 0, now[:, None] + np.log(level), ahead))
