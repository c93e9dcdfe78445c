"""Paths of a drive's state past its last test."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.kalman_filter import RATE, RUNNING_IN
from hdprog.trend.smoother import walked
from hdprog.trend.state_space import Steps
from hdprog.trend.wear_prior import MESH, HeavyTailed, RateAhead

_SLOWEST = 0.02  # of the clock's rate: what a drive goes on with that seems to stand still
_LEAST_RATE = 0.5  # of the clock's, that a wander is told as a share of: less would be all wander
_FASTEST_LOG = 6.0  # four hundred times as fast is beyond any figure
_NO_FALL = 1e-9
_MOST_LEFT, _LEAST_LEFT = 0.7, 1e-6  # of what a parameter that falls is now, when it is worn out
_LEAST_LEVEL = 1e-9  # of a belief, so that its quantile is finite
_FARTHEST = 15.0  # prior spreads of a coordinate from its prior mean: figures stay finite


def simulate_ahead(
    steps: Steps,
    rng: np.random.Generator,
    start: tuple[FloatArray, FloatArray],
    first: int,
    ahead: RateAhead,
) -> FloatArray:
    """Draw states after the last test, where the rate of wear changes by factors.

    Seen from tests, the rate's departure is linear, so that a filter can follow it. Ahead all that
    goes on, by the drive's own loadings and by the departure, goes on exp(W) times as fast, with a
    random walk W: a rate does not run below zero, one that has grown may grow on, and what has
    levelled off stays level. W spreads as the logarithm of the rate does: the departure's walk is
    in units of the clock's rate, and where the rate has grown to several times that, the same walk
    is so many times less of it. W drifts upwards, as the last stage of wear is the one that speeds
    up; where the pace is steady, it stays so. Loadings walk on as before.

    Parameters
    ----------
    steps : of every draw
    rng : source of randomness
    start : state (draws, n) and carried (draws, k), see `kalman_filter`, just before `first`
    first : first time to draw
    ahead : spread of W over that of the departure in the past, per rate, and its drift

    Returns
    -------
    states (draws, times − first, n)
    """
    draws, times = steps.wear.shape
    x, c = start
    walk, loadings = np.zeros(draws), c[:, : steps.size]
    spread = ahead.spread / np.maximum(1.0 + c[:, RATE], _LEAST_RATE)
    states = np.empty((draws, times - first, steps.size))
    for time in range(first, times):
        wear, passed = steps.wear[:, time], steps.passed[:, time]
        common, turn, lead = rng.standard_normal((3, draws))
        departure = spread * np.sqrt(steps.departure[:, time])
        drift = np.where(departure > 0, ahead.drift * steps.lived[:, time], 0.0)
        meanwhile = walk + drift / 2 + departure * (turn / 2 + lead / np.sqrt(12))
        factor = np.exp(np.minimum(meanwhile, _FASTEST_LOG))
        departed = np.maximum(passed * c[:, RATE], (_SLOWEST - 1.0) * wear)
        beside = np.sqrt(steps.shared[:, time]) * common
        beside = beside + steps.settled[:, time] * c[:, RUNNING_IN]
        own = np.sqrt(steps.own[:, time]) * rng.standard_normal((draws, steps.size))
        pace, loadings = walked(loadings, steps.loading_walk[:, time], rng)
        going = wear[:, None] * pace + departed[:, None] * steps.direction
        x = x + factor[:, None] * going + beside[:, None] * steps.direction + own
        walk = walk + drift + departure * turn
        states[:, time - first] = x
    return states


def within_reach(steps: Steps, states: FloatArray) -> FloatArray:
    """States (..., n), held where figures stay finite."""
    farthest = _FARTHEST * np.sqrt(steps.initial_variance)
    return np.clip(states, steps.initial_mean - farthest, steps.initial_mean + farthest)


def worn_ahead(
    steps: Steps,
    now: FloatArray,
    ahead: FloatArray,
    ends: Mapping[str, HeavyTailed],
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """States to come with an end to the wear of each place, held within reach.

    Where b or T_i would fall below its end, it tends to it instead (see `level_off`), and what
    wears at the same place goes on from now by the same share of its way: preload and friction with
    T_i, teeth and all else with b. Teeth at their end do not hold up the loss of preload.

    Parameters
    ----------
    steps : of every draw
    now : (draws, n) wear coordinates at present
    ahead : (draws, times, n) to come, without an end
    ends : of b and T_i, where there is one, the value worn out over the loop prior's median
    rng : source of randomness

    Returns
    -------
    (draws, times, n) to come, and how much of a small step made then is left of it, as the slope of
    b's or T_i's own way has it
    """
    way = ahead - now[:, None]
    left = np.ones_like(way)
    mesh = np.isin(np.arange(way.shape[-1]), MESH)
    for shown, place in (("b", ~mesh), ("T_i", mesh)):
        if shown in ends:
            at = NAMES.index(shown)
            end = left_worn_out(ends[shown], now[:, at] - steps.initial_mean[at], rng)
            fall = -way[..., at]
            left[..., place] = _left_of_step(fall, end)[..., None]
            way[..., place] *= _share_of_way(fall, end)[..., None]
    return within_reach(steps, now[:, None] + way), left


def _share_of_way(fall: FloatArray, end: FloatArray) -> FloatArray:
    """(draws, times) how much of a fall comes, and of what goes along with it."""
    falls = fall > _NO_FALL
    return np.where(falls, level_off(fall, end) / np.where(falls, fall, 1.0), 1.0)


def _left_of_step(fall: FloatArray, end: FloatArray) -> FloatArray:
    """(draws, times) slope of `level_off`."""
    share = end[:, None]
    going = np.exp(-np.maximum(fall, 0.0) / (1 - share))
    return np.asarray(going / (share + (1 - share) * going))


def left_worn_out(belief: HeavyTailed, present: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Draw what a parameter that falls tends to, over its present value: (draws,), below 1.

    What wears still is not at its end, however far below all others it lies: the belief is cut off
    below the present value, and its tail is heavy, so that what is left of it does not crowd there.

    Parameters
    ----------
    belief : its value worn out, over the loop prior's median
    present : (draws,) logarithm of its present value over that median
    rng : source of randomness
    """
    highest = belief.below(present + np.log(_MOST_LEFT))
    level = np.maximum(rng.uniform(size=present.size) * highest, _LEAST_LEVEL)
    return np.asarray(np.clip(np.exp(belief.log_at(level) - present), _LEAST_LEFT, _MOST_LEFT))


def level_off(fall: FloatArray, end: FloatArray) -> FloatArray:
    """Let the logarithm of a parameter, where it falls, tend to its end.

    With f the end over the present value, the parameter is f + (1 − f)·exp(−fall/(1 − f)) times
    what it is now: the slope at now is kept.

    Parameters
    ----------
    fall : (draws, times) of the logarithm, without an end
    end : (draws,) f, below 1

    Returns
    -------
    (draws, times) fall of the logarithm
    """
    share = end[:, None]
    level = share + (1 - share) * np.exp(-np.maximum(fall, 0.0) / (1 - share))
    return np.asarray(np.where(fall > 0, -np.log(level), fall))
