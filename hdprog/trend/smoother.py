"""Smoothed states, states drawn from the model, and states drawn given all loops.

The backward recursion is that of Bryson & Frazier (1963), in information form; see
`kalman_filter`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hdprog.physics.parameters import FloatArray
from hdprog.trend.kalman_filter import (
    RATE,
    RUNNING_IN,
    Kept,
    carried_at_first,
    carries_of,
    per_step_of_warmth,
    run_filter,
)
from hdprog.trend.observation import Observations
from hdprog.trend.state_space import Steps


def smooth(
    steps: Steps, precision: FloatArray, information: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Mean of the states at every time given all loops, and of what the last carries.

    Parameters
    ----------
    steps : of every draw
    precision, information : (draws, times, n, n), (draws, times, n) of x(t), scatter taken out

    Returns
    -------
    states (draws, times, n), and what the last carries (draws, k)
    """
    kept: list[Kept] = []
    run_filter(steps, precision, information, np.zeros(steps.wear.shape[0]), kept)
    draws, times = steps.wear.shape
    states = np.empty((draws, times, steps.size))
    carried = np.empty((draws, steps.carried))
    on_x, on_c = np.zeros((draws, steps.size)), np.zeros((draws, steps.carried))
    for time in range(times - 1, -1, -1):
        at = kept[time]
        seen = (at.xx @ on_x[..., None] + at.xc @ on_c[..., None])[..., 0]
        on_x = at.pull + on_x - (at.gain @ seen[..., None])[..., 0]
        states[:, time] = at.x + (at.xx @ on_x[..., None] + at.xc @ on_c[..., None])[..., 0]
        if time == times - 1:
            cx = np.swapaxes(at.xc, -1, -2)
            carried = at.c + (cx @ on_x[..., None])[..., 0]
        on_c = on_c + (np.swapaxes(carries_of(steps, time), -1, -2) @ on_x[..., None])[..., 0]
        if steps.begins[time]:
            on_x, on_c = np.zeros_like(on_x), np.zeros_like(on_c)
    return states, carried


def simulate(
    steps: Steps,
    rng: np.random.Generator,
    start: tuple[FloatArray, FloatArray] | None = None,
    first: int = 0,
) -> tuple[FloatArray, FloatArray]:
    """Draw states from the model without any loop.

    Parameters
    ----------
    steps : of every draw
    rng : source of randomness
    start : state (draws, n) and carried (draws, k) just before `first`; drawn where a drive
        begins
    first : first time to draw

    Returns
    -------
    states (draws, times − first, n), and what the last carries (draws, k)
    """
    draws, times = steps.wear.shape
    count = steps.size
    x, c = (np.zeros((draws, count)), np.zeros((draws, steps.carried))) if start is None else start
    states = np.empty((draws, times - first, count))
    for time in range(first, times):
        if steps.begins[time]:
            mean, variance = carried_at_first(steps)
            x, c = rng.standard_normal((draws, count)), rng.standard_normal((draws, steps.carried))
            x = steps.initial_mean + np.sqrt(steps.initial_variance) * x
            c = mean + np.sqrt(variance) * c
        wear, passed = steps.wear[:, time], steps.passed[:, time]
        common, turn, lead = rng.standard_normal((3, draws))
        departure = np.sqrt(steps.departure[:, time])
        gained = passed * (c[:, RATE] + departure * (turn / 2 + lead / np.sqrt(12)))
        gained = gained + np.sqrt(steps.shared[:, time]) * common
        gained = gained + steps.settled[:, time] * c[:, RUNNING_IN]
        own = np.sqrt(steps.own[:, time]) * rng.standard_normal((draws, count))
        x = x + wear[:, None] * c[:, :count] + gained[:, None] * steps.direction + own
        if steps.warming is not None:
            x = x + steps.warming.warmed[time] * per_step_of_warmth(steps, c)
        c = np.column_stack([c[:, :RATE], c[:, RATE] + departure * turn])
        states[:, time - first] = x
    return states, c


def draw(
    steps: Steps, observations: Observations, scatter: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Draw states given all loops, one path for each draw of `steps`.

    A path drawn from the model, corrected by the smoothed mean of what the loops say beyond it
    (Durbin & Koopman, Biometrika 89, 2002).

    Returns
    -------
    states (draws, times, n), and what the last carries (draws, k)
    """
    precision, information, _ = observations.behind_scatter(scatter)
    states, carried = simulate(steps, rng)
    said = (precision @ states[..., None])[..., 0] + observations.draw_noise(scatter, rng)
    correction = correct(steps, precision, information - said)
    return states + correction[0], carried + correction[1]


def correct(
    steps: Steps, precision: FloatArray, beyond: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What to add to a course drawn from the model for what the loops say beyond it.

    Parameters
    ----------
    steps : of every draw
    precision : Λ (draws, times, n, n)
    beyond : (draws, times, n) information less Λ times the course, less noise of covariance Λ

    Returns
    -------
    as `smooth`
    """
    nothing = np.zeros(steps.size)
    around_zero = replace(
        steps,
        initial_mean=nothing,
        loading_mean=nothing[None],
        running_in=(0.0, steps.running_in[1]),
        warming=None if steps.warming is None else replace(steps.warming, mean=nothing),
    )
    return smooth(around_zero, precision, beyond)
