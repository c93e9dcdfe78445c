"""Kalman filter over the loops in information form, for many draws at once.

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

from dataclasses import dataclass

import numpy as np

from hdprog.physics.parameters import FloatArray
from hdprog.trend.observation import Observations
from hdprog.trend.state_space import Steps

RUNNING_IN, RATE = -2, -1
"""Where what is carried along holds the extent of running-in and the rate's departure."""


def carries_of(steps: Steps, time: int) -> FloatArray:
    """How x moves by what it carries, (draws, n, k): L by wear, β by warmth, the rest along m."""
    moves = steps.wear[:, time, None, None] * np.eye(steps.size, steps.carried)
    if steps.warming is not None:
        moves += steps.warming.warmed[time] * np.eye(steps.size, steps.carried, steps.size)
    moves[..., RUNNING_IN] = steps.settled[:, time, None] * steps.direction
    moves[..., RATE] = steps.passed[:, time, None] * steps.direction
    return moves


def carried_at_first(steps: Steps) -> tuple[FloatArray, FloatArray]:
    """Mean and variance (draws, k) of what a new drive carries.

    Its rate is the clock's.
    """
    extent, variance = steps.running_in
    loadings = np.broadcast_to(steps.loading_mean, (len(steps.wear), steps.size))
    warmer, unsure = (), ()
    if steps.warming is not None:
        warmer, unsure = tuple(steps.warming.mean), tuple(steps.warming.variance)
    beside = np.tile([*warmer, extent, 0.0], (len(loadings), 1))
    spread = np.broadcast_to(steps.loading_variance, loadings.shape)
    around = np.tile([*unsure, variance, 0.0], (len(loadings), 1))
    return np.hstack([loadings, beside]), np.hstack([spread, around])


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
class Predicted:
    """Prediction of x and of what it carries, for every draw; c stands for the carried."""

    x: FloatArray  # (draws, n)
    c: FloatArray  # (draws, k)
    xx: FloatArray
    xc: FloatArray
    cc: FloatArray

    @staticmethod
    def new(steps: Steps, draws: int) -> Predicted:
        """Before the first hour of a drive."""
        mean, variance = carried_at_first(steps)
        return Predicted(
            np.tile(steps.initial_mean, (draws, 1)),
            mean,
            np.tile(np.diag(steps.initial_variance), (draws, 1, 1)),
            np.zeros((draws, steps.size, steps.carried)),
            variance[..., None] * np.eye(steps.carried),
        )

    def advance(self, steps: Steps, direction: FloatArray, time: int) -> None:
        """Wear and wander from the time before to this one."""
        moves = carries_of(steps, time)
        carried = moves @ self.cc
        cross = self.xc @ np.swapaxes(moves, -1, -2)
        passed = steps.passed[:, time]
        departure = steps.departure[:, time]  # spread evenly over what has passed
        shared = steps.shared[:, time] + departure * passed**2 / 3
        wear, walk = steps.wear[:, time, None], steps.loading_walk[:, time]
        alone = steps.own[:, time] + walk * wear**2 / 3  # a walk and its mean over the stretch
        each = np.arange(steps.size)
        self.x = self.x + (moves @ self.c[..., None])[..., 0]
        self.xx = self.xx + cross + np.swapaxes(cross, -1, -2)
        self.xx += carried @ np.swapaxes(moves, -1, -2)
        self.xx += shared[:, None, None] * direction
        self.xx[:, each, each] += alone
        self.xc = self.xc + carried
        self.xc[:, each, each] += walk * wear / 2
        self.xc[..., RATE] += (departure * passed / 2)[:, None] * steps.direction
        self.cc = self.cc.copy()
        self.cc[:, each, each] += walk
        self.cc[..., RATE, RATE] += departure


@dataclass(frozen=True)
class Kept:
    """What the backward recursion needs of one time."""

    x: FloatArray
    c: FloatArray
    xx: FloatArray
    xc: FloatArray
    cc: FloatArray
    gain: FloatArray  # G
    pull: FloatArray  # u


def _update(
    now: Predicted, precision: FloatArray, information: FloatArray
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
    return run_filter(steps, *observations.behind_scatter(scatter), keep=None)


def run_filter(
    steps: Steps,
    precision: FloatArray,
    information: FloatArray,
    log_factor: FloatArray,
    keep: list[Kept] | None,
) -> FloatArray:
    """Run the filter over all times.

    Parameters
    ----------
    steps : of every draw
    precision, information : Λ (draws, times, n, n) and η (draws, times, n) of x
    log_factor : (draws,) to begin with
    keep : what the backward recursion needs is appended here, one a time

    Returns
    -------
    (draws,) log of the likelihood of all loops
    """
    draws, times = steps.wear.shape
    direction = np.outer(steps.direction, steps.direction)
    total = log_factor.copy()
    now = Predicted.new(steps, draws)
    informed = np.any(precision != 0, axis=(0, 2, 3))
    for time in range(times):
        if steps.begins[time] and time > 0:
            now = Predicted.new(steps, draws)
        now.advance(steps, direction, time)
        before = (now.x, now.c, now.xx, now.xc, now.cc)
        gain, pull = np.zeros_like(now.xx), np.zeros_like(now.x)
        if informed[time]:
            gain, pull, factor = _update(now, precision[:, time], information[:, time])
            total += factor
        if keep is not None:
            keep.append(Kept(*before, gain, pull))
    return total
