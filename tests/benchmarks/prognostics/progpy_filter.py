"""ProgPy's unscented Kalman filter and Monte Carlo prediction, with a figure that grows at a pace.

The model is generic: x grows by r, both wander. ProgPy has no fleet; what a user would read off the
other units' readings is computed here by moments: mean and spread of the pace between units (the
filter's start), noise of readings and wander of x (variance and covariance of neighbouring
differences), wander of r (difference of a unit's pace between its halves).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from progpy import PrognosticsModel
from progpy.predictors import MonteCarlo
from progpy.state_estimators import UnscentedKalmanFilter
from progpy.uncertain_data import MultivariateNormalDist

from tests.benchmarks.prognostics.fleets import HORIZON, NOW, SEEN, TEST_HOURS
from tests.benchmarks.prognostics.laws import FloatArray
from tests.benchmarks.prognostics.method import Learnt, Told, of_crossings

FILTER = "ProgPy"
_DRAWS = 300
_STEP_HOURS = 10.0
_LEAST = 1e-4  # of a standard deviation in ways to failure: a filter needs some


class GrowingFigure(PrognosticsModel):
    """x' = r; fails where x reaches one."""

    inputs: list[str] = []  # noqa: RUF012  # as ProgPy declares its models
    states = ["x", "r"]  # noqa: RUF012
    outputs = ["reading"]  # noqa: RUF012
    events = ["failure"]  # noqa: RUF012
    default_parameters = {"x0": {"x": 0.0, "r": 1e-3}}  # noqa: RUF012

    def next_state(self, x, u, dt):
        grown = [np.atleast_1d(x["x"] + x["r"] * dt), np.atleast_1d(x["r"])]
        return self.StateContainer(np.array(grown))

    def output(self, x):
        return self.OutputContainer(np.array([np.atleast_1d(x["x"])]))

    def event_state(self, x):
        return {"failure": 1.0 - x["x"]}

    def threshold_met(self, x):
        return {"failure": x["x"] >= 1.0}


@dataclass(frozen=True)
class Moments:
    """Standard deviations: of a reading, of x and r per root of an hour, and of the pace."""

    noise: float
    wander: float
    change: float
    pace: float
    pace_spread: float


def moments(others: FloatArray) -> Moments:
    """From the other units' readings (units, 10)."""
    hours = TEST_HOURS
    step = float(hours[2] - hours[1])
    steps = np.diff(others, axis=1)
    around = steps - steps.mean(axis=1, keepdims=True)
    # Removing the mean of m differences leaves (m − 1)/m of their variance.
    share = 1.0 - 1.0 / steps.shape[1]
    variance = float(np.mean(around**2)) / share
    neighbours = float(np.mean(around[:, 1:] * around[:, :-1]))
    noise = max(-neighbours, _LEAST**2)
    wander = max(variance - 2.0 * noise, _LEAST**2) / step
    half = others.shape[1] // 2
    early = np.polyfit(hours[:half], others[:, :half].T, 1)[0]
    late = np.polyfit(hours[half:], others[:, half:].T, 1)[0]
    apart = half * step
    own = 2.0 * noise / np.sum((hours[half:] - hours[half:].mean()) ** 2)
    own += 2.0 * wander / ((half - 1) * step)
    change = max(float(np.mean((late - early) ** 2)) - own, 0.0) / apart
    pace = np.polyfit(hours, others.T, 1)[0]
    return Moments(
        float(np.sqrt(noise)),
        float(np.sqrt(wander)),
        float(np.sqrt(max(change, (_LEAST / apart) ** 2 / apart))),
        float(pace.mean()),
        float(max(pace.std(ddof=1), 0.01 * abs(pace.mean()))),
    )


def _model(known: Moments) -> GrowingFigure:
    root = np.sqrt(_STEP_HOURS)  # ProgPy multiplies its noise by the step
    return GrowingFigure(
        process_noise={"x": known.wander / root, "r": known.change / root},
        measurement_noise={"reading": known.noise},
        dt=_STEP_HOURS,
    )


def learn(others: FloatArray, rng: np.random.Generator) -> Learnt:
    """Take the moments."""
    known = moments(others)

    def forecast(values: FloatArray, rng: np.random.Generator) -> Told:
        np.random.seed(int(rng.integers(2**31)))  # noqa: NPY002  # ProgPy draws from there
        model = _model(known)
        start = MultivariateNormalDist(
            ["x", "r"], [0.0, known.pace], np.diag([_LEAST**2, known.pace_spread**2])
        )
        seen = UnscentedKalmanFilter(
            model,
            start,
            Q=np.diag([known.wander**2, known.change**2]) * _STEP_HOURS,
            R=np.array([[known.noise**2]]),
            dt=_STEP_HOURS,  # Q counts once a step
        )
        nothing = model.InputContainer({})
        for hour, value in zip(TEST_HOURS[:SEEN], values, strict=True):
            seen.estimate(float(hour), nothing, model.OutputContainer({"reading": value}))
        # The filter leaves its model without process noise: the prediction gets one of its own.
        found = MonteCarlo(_model(known)).predict(
            seen.x,
            lambda t, x=None: nothing,
            t0=NOW,
            dt=_STEP_HOURS,
            n_samples=_DRAWS,
            horizon=HORIZON - NOW,
            save_freq=HORIZON,
        )
        times = [np.inf if at is None else float(at) for at in found.time_of_event.key("failure")]
        # A crossing is told at the end of its step: take the middle.
        return Told({FILTER: of_crossings(np.array(times) - 0.5 * _STEP_HOURS)})

    return Learnt(forecast)
