"""Kalman filter and smoother over the loops in information form, for many draws at once.

The state is x, n numbers, and what it carries along, k = n + 2 or 2n + 2: the loadings L, the
change β by 10 K where temperature counts, the extent of running-in r and the rate's departure v. A
loop informs x only. With Λ, η what it says of x and P, m the prediction, W = (I + ΛP)⁻¹,
u = W(η − Λm), G = WΛ give the update

    m ← m + P u,   P ← P − P G P

without inverting P or Λ, so that a loop that says nothing is no special case (Durbin & Koopman,
Time Series Analysis by State Space Methods, 2nd ed. 2012, ch. 4; the backward recursion is that of
Bryson & Frazier, 1963).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray
from hdprog.trend.observation import Observations
from hdprog.trend.state_space import Steps

RUNNING_IN, RATE = -2, -1
"""Where what is carried along holds the extent of running-in and the rate's departure."""


def _carries(steps: Steps, time: int) -> FloatArray:
    """How x moves by what it carries, (draws, n, k): L by wear, β by warmth, the rest along m."""
    moves = steps.wear[:, time, None, None] * np.eye(steps.size, steps.carried)
    if steps.warming is not None:
        moves += steps.warming.warmed[time] * np.eye(steps.size, steps.carried, steps.size)
    moves[..., RUNNING_IN] = steps.settled[:, time, None] * steps.direction
    moves[..., RATE] = steps.passed[:, time, None] * steps.direction
    return moves


def _carried_at_first(steps: Steps) -> tuple[FloatArray, FloatArray]:
    """Mean (draws, k) and variance (k,) of what a new drive carries.

    Its rate is the clock's.
    """
    extent, variance = steps.running_in
    loadings = np.broadcast_to(steps.loading_mean, (len(steps.wear), steps.size))
    warmer, unsure = (), ()
    if steps.warming is not None:
        warmer, unsure = tuple(steps.warming.mean), tuple(steps.warming.variance)
    beside = np.tile([*warmer, extent, 0.0], (len(loadings), 1))
    return (
        np.concatenate([loadings, beside], axis=1),
        np.concatenate([steps.loading_variance, [*unsure, variance, 0.0]]),
    )


def per_step_of_warmth(steps: Steps, carried: FloatArray) -> FloatArray:
    """β (draws, n) out of what is carried (draws, k); zero where temperature does not count."""
    count = steps.size
    if steps.warming is None:
        return np.zeros((len(carried), count))
    return np.asarray(carried[:, count : 2 * count])


def at_reference(steps: Steps, state: FloatArray, carried: FloatArray, time: int) -> FloatArray:
    """State (draws, n) at a time as it is at the reference temperature; carried (draws, k)."""
    if steps.warming is None:
        return state
    return np.asarray(state - steps.warming.warmth[time] * per_step_of_warmth(steps, carried))


@dataclass
class _Predicted:
    """Prediction of x and of what it carries, for every draw; c stands for the carried."""

    x: FloatArray  # (draws, n)
    c: FloatArray  # (draws, k)
    xx: FloatArray
    xc: FloatArray
    cc: FloatArray

    @staticmethod
    def new(steps: Steps, draws: int) -> _Predicted:
        """Before the first hour of a drive."""
        mean, variance = _carried_at_first(steps)
        return _Predicted(
            np.tile(steps.initial_mean, (draws, 1)),
            mean,
            np.tile(np.diag(steps.initial_variance), (draws, 1, 1)),
            np.zeros((draws, steps.size, variance.size)),
            np.tile(np.diag(variance), (draws, 1, 1)),
        )

    def advance(self, steps: Steps, direction: FloatArray, time: int) -> None:
        """Wear and wander from the time before to this one."""
        moves = _carries(steps, time)
        carried = moves @ self.cc
        cross = self.xc @ np.swapaxes(moves, -1, -2)
        passed = steps.passed[:, time]
        departure = steps.departure[:, time]  # spread evenly over what has passed
        shared = steps.shared[:, time] + departure * passed**2 / 3
        self.x = self.x + (moves @ self.c[..., None])[..., 0]
        self.xx = self.xx + cross + np.swapaxes(cross, -1, -2)
        self.xx += carried @ np.swapaxes(moves, -1, -2)
        self.xx += shared[:, None, None] * direction
        self.xx += steps.own[:, time, :, None] * np.eye(steps.size)
        self.xc = self.xc + carried
        self.xc[..., RATE] += (departure * passed / 2)[:, None] * steps.direction
        self.cc = self.cc.copy()
        self.cc[..., RATE, RATE] += departure


@dataclass(frozen=True)
class _Kept:
    """What the backward recursion needs of one time."""

    x: FloatArray
    c: FloatArray
    xx: FloatArray
    xc: FloatArray
    cc: FloatArray
    gain: FloatArray  # G
    pull: FloatArray  # u


def _update(
    now: _Predicted, precision: FloatArray, information: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Take in one loop, in place; returns G, u and the log of its predictive factor."""
    surprise = information - (precision @ now.x[..., None])[..., 0]
    matrix = precision @ now.xx + np.eye(now.x.shape[-1])
    right = np.concatenate([precision, surprise[..., None]], axis=-1)
    solved = np.linalg.solve(matrix, right)
    gain, pull = solved[..., :-1], solved[..., -1]
    moved = (now.xx @ pull[..., None])[..., 0]
    log_factor = (
        -0.5 * np.linalg.slogdet(matrix)[1]
        + 0.5 * np.sum(surprise * moved, axis=-1)
        + 0.5 * np.sum((surprise + information) * now.x, axis=-1)
    )
    cx = np.swapaxes(now.xc, -1, -2)
    now.c = now.c + (cx @ pull[..., None])[..., 0]
    now.x = now.x + moved
    weighted = gain @ now.xc
    now.cc = now.cc - cx @ weighted
    now.xc = now.xc - now.xx @ weighted
    shrunk = now.xx - now.xx @ (gain @ now.xx)
    now.xx = 0.5 * (shrunk + np.swapaxes(shrunk, -1, -2))
    return gain, pull, log_factor


def log_evidence(steps: Steps, scatter: FloatArray, observations: Observations) -> FloatArray:
    """Log of the likelihood of all loops, states and loadings integrated out, (draws,)."""
    return _filter(steps, *observations.behind_scatter(scatter), keep=None)


@dataclass(frozen=True)
class Predictor:
    """Prediction of each test from those before it, for courses that were met exactly.

    Spreads hang on the tests' precisions alone: once known, a course costs a few products.

    Attributes
    ----------
    steps : of every draw
    carries : (times) of (draws, n, k) how x moves by what it carries
    gain : (times) of (draws, n, n) inverse covariance of what a test shows beyond its prediction
    xx, cx : (times) of (draws, n, n) and (draws, k, n), predicted covariances
    """

    steps: Steps
    carries: tuple[FloatArray, ...]
    gain: tuple[FloatArray, ...]
    xx: tuple[FloatArray, ...]
    cx: tuple[FloatArray, ...]

    @staticmethod
    def of(steps: Steps, precision: FloatArray) -> Predictor:
        """From the inverse covariance of what was met about the state, (draws, times, n, n)."""
        kept: list[_Kept] = []
        draws, times = steps.wear.shape
        _filter(steps, precision, np.zeros(precision.shape[:-1]), np.zeros(draws), kept)
        return Predictor(
            steps,
            tuple(_carries(steps, time) for time in range(times)),
            tuple(one.gain for one in kept),
            tuple(one.xx for one in kept),
            tuple(np.swapaxes(one.xc, -1, -2) for one in kept),
        )

    def rows(self, chosen: NDArray[np.intp]) -> Predictor:
        """Keep some of the draws."""
        each = (self.carries, self.gain, self.xx, self.cx)
        kept = (tuple(one[chosen] for one in some) for some in each)
        return Predictor(self.steps.rows(chosen), *kept)

    def squares(self, met: FloatArray) -> FloatArray:
        """Squared surprise (courses, draws) of courses (courses, draws, times, n).

        −½ of it is the log density of a course, up to a constant of each draw.
        """
        first, _ = _carried_at_first(self.steps)
        total = np.zeros(met.shape[:2])
        for time, (carries, gain, xx, cx) in enumerate(
            zip(self.carries, self.gain, self.xx, self.cx, strict=True)
        ):
            if self.steps.begins[time]:
                x, c = self.steps.initial_mean, first
            x = x + np.matmul(carries, c[..., None])[..., 0]
            off = met[:, :, time] - x
            pull = np.matmul(gain, off[..., None])[..., 0]
            total += np.sum(off * pull, axis=-1)
            x = x + np.matmul(xx, pull[..., None])[..., 0]
            c = c + np.matmul(cx, pull[..., None])[..., 0]
        return total


def _filter(
    steps: Steps,
    precision: FloatArray,
    information: FloatArray,
    log_factor: FloatArray,
    keep: list[_Kept] | None,
) -> FloatArray:
    draws, times = steps.wear.shape
    direction = np.outer(steps.direction, steps.direction)
    total = log_factor.copy()
    now = _Predicted.new(steps, draws)
    informed = np.any(precision != 0, axis=(0, 2, 3))
    for time in range(times):
        if steps.begins[time] and time > 0:
            now = _Predicted.new(steps, draws)
        now.advance(steps, direction, time)
        before = (now.x, now.c, now.xx, now.xc, now.cc)
        gain, pull = np.zeros_like(now.xx), np.zeros_like(now.x)
        if informed[time]:
            gain, pull, factor = _update(now, precision[:, time], information[:, time])
            total += factor
        if keep is not None:
            keep.append(_Kept(*before, gain, pull))
    return total


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
    kept: list[_Kept] = []
    _filter(steps, precision, information, np.zeros(steps.wear.shape[0]), kept)
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
        on_c = on_c + (np.swapaxes(_carries(steps, time), -1, -2) @ on_x[..., None])[..., 0]
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
            mean, variance = _carried_at_first(steps)
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
