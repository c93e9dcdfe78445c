"""Smoothed states, states drawn from the model, and states drawn given all loops.

The backward recursion is that of Bryson & Frazier (1963), in information form; see
`kalman_filter`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

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


@dataclass(frozen=True)
class Course:
    """States along the times, with what they carry at the last and where its loadings began.

    Attributes
    ----------
    states : (draws, times, n)
    carried : (draws, k) after the last time
    loadings : (draws, n) with which the drive of the last time began; those carried have walked
        since
    """

    states: FloatArray
    carried: FloatArray
    loadings: FloatArray

    def corrected(self, by: Course) -> Course:
        """Add another course."""
        return Course(
            self.states + by.states, self.carried + by.carried, self.loadings + by.loadings
        )


def smooth(steps: Steps, precision: FloatArray, information: FloatArray) -> Course:
    """Mean of the course given all loops.

    Parameters
    ----------
    steps : of every draw
    precision, information : (draws, times, n, n), (draws, times, n) of x(t), scatter taken out
    """
    kept: list[Kept] = []
    run_filter(steps, precision, information, np.zeros(steps.wear.shape[0]), kept)
    draws, times = steps.wear.shape
    states = np.empty((draws, times, steps.size))
    carried, (first, variance) = np.empty((draws, steps.carried)), carried_at_first(steps)
    loadings, count = None, steps.size
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
            if loadings is None:
                loadings = (first + variance * on_c)[:, :count]
            on_x, on_c = np.zeros_like(on_x), np.zeros_like(on_c)
    assert loadings is not None  # a drive begins at the first time
    return Course(states, carried, loadings)


def simulate(steps: Steps, rng: np.random.Generator) -> Course:
    """Draw a course from the model without any loop.

    Parameters
    ----------
    steps : of every draw
    rng : source of randomness
    """
    draws, times = steps.wear.shape
    count = steps.size
    states = np.empty((draws, times, count))
    x, c, loadings = np.empty((draws, count)), np.empty((draws, steps.carried)), np.empty(0)
    for time in range(times):
        if steps.begins[time]:
            mean, variance = carried_at_first(steps)
            x, c = rng.standard_normal((draws, count)), rng.standard_normal((draws, steps.carried))
            x = steps.initial_mean + np.sqrt(steps.initial_variance) * x
            c = mean + np.sqrt(variance) * c
            loadings = c[:, :count]
        x, c = advanced(steps, time, x, c, rng)
        states[:, time] = x
    return Course(states, c, loadings)


def advanced(
    steps: Steps, time: int, x: FloatArray, c: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """State (draws, n) and what it carries (draws, k) at a time, from those at the time before."""
    draws, count = x.shape
    wear, passed = steps.wear[:, time], steps.passed[:, time]
    common, turn, lead = rng.standard_normal((3, draws))
    departure = np.sqrt(steps.departure[:, time])
    gained = passed * (c[:, RATE] + departure * (turn / 2 + lead / np.sqrt(12)))
    gained = gained + np.sqrt(steps.shared[:, time]) * common
    gained = gained + steps.settled[:, time] * c[:, RUNNING_IN]
    pace, turned = walked(c[:, :count], steps.loading_walk[:, time], rng)
    own = np.sqrt(steps.own[:, time]) * rng.standard_normal((draws, count))
    x = x + wear[:, None] * pace + gained[:, None] * steps.direction + own
    if steps.warming is not None:
        x = x + steps.warming.warmed[time] * per_step_of_warmth(steps, c)
    return x, np.column_stack([turned, c[:, count:RATE], c[:, RATE] + departure * turn])


def walked(
    loadings: FloatArray, variance: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Mean of walking loadings over a stretch, and where they end, (draws, n) each.

    Parameters
    ----------
    loadings : (draws, n) at the beginning of the stretch
    variance : (draws, n) that they gain on it, evenly by wear
    rng : source of randomness
    """
    spread, turn = np.sqrt(variance), rng.standard_normal(loadings.shape)
    lead = rng.standard_normal(loadings.shape)
    # A walk's mean over a stretch given where it ends (Brownian bridge).
    return loadings + spread * (turn / 2 + lead / np.sqrt(12)), loadings + spread * turn


def draw(
    steps: Steps, observations: Observations, scatter: FloatArray, rng: np.random.Generator
) -> Course:
    """Draw a course given all loops, one path for each draw of `steps`.

    A path drawn from the model, corrected by the smoothed mean of what the loops say beyond it
    (Durbin & Koopman, Biometrika 89, 2002).
    """
    precision, information, _ = observations.behind_scatter(scatter)
    course = simulate(steps, rng)
    said = (precision @ course.states[..., None])[..., 0] + observations.draw_noise(scatter, rng)
    return course.corrected(correct(steps, precision, information - said))


def correct(steps: Steps, precision: FloatArray, beyond: FloatArray) -> Course:
    """What to add to a course drawn from the model for what the loops say beyond it.

    Parameters
    ----------
    steps : of every draw
    precision : Λ (draws, times, n, n)
    beyond : (draws, times, n) information less Λ times the course, less noise of covariance Λ
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
