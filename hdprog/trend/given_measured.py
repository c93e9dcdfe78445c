"""The trend where it is known what every test met: its density, and the states behind it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray
from hdprog.trend.kalman_filter import Kept, carried_at_first, carries_of, run_filter
from hdprog.trend.smoother import Course, correct, simulate
from hdprog.trend.state_space import Steps


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
        kept: list[Kept] = []
        draws, times = steps.wear.shape
        run_filter(steps, precision, np.zeros(precision.shape[:-1]), np.zeros(draws), kept)
        return Predictor(
            steps,
            tuple(carries_of(steps, time) for time in range(times)),
            tuple(one.gain for one in kept),
            tuple(one.xx for one in kept),
            tuple(np.swapaxes(one.xc, -1, -2) for one in kept),
        )

    def squares(self, met: FloatArray) -> FloatArray:
        """Squared surprise (courses, draws) of courses (courses, draws, times, n).

        −½ of it is the log density of a course, up to a constant of each draw.
        """
        first, _ = carried_at_first(self.steps)
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


@dataclass(frozen=True)
class GivenMeasured:
    """The trend along tests, and the spread of what they met about the states.

    Attributes
    ----------
    steps : of every draw of the hyperparameters, along the tests
    precision : (draws, tests, n, n) inverse covariance of what a test met, given the state
    """

    steps: Steps
    precision: FloatArray

    @staticmethod
    def of(
        steps: Steps, scatter: FloatArray, scales: FloatArray, unknown_part: FloatArray | None
    ) -> GivenMeasured:
        """From the scatter of remounting (draws,), its relative sizes (n,) and unknown warmth.

        `unknown_part` is that of `temperature.SeenTests`, (tests, n, n) or None.
        """
        variance = (scatter[:, None] * scales) ** 2
        tests = steps.wear.shape[1]
        if unknown_part is None:
            precision = (1.0 / variance[..., None]) * np.eye(scales.size)
            each = np.broadcast_to(precision[:, None], (len(scatter), tests, *precision.shape[1:]))
            return GivenMeasured(steps, each)
        whole = variance[:, None, :, None] * np.eye(scales.size) + unknown_part
        return GivenMeasured(steps, np.asarray(np.linalg.inv(whole)))

    @cached_property
    def predictor(self) -> Predictor:
        """Of every test from those before it."""
        return Predictor.of(self.steps, self.precision)

    def draw_behind(
        self,
        measured: FloatArray,
        along: Steps,
        which: NDArray[np.intp],
        rng: np.random.Generator,
    ) -> Course:
        """Draw a course given what the tests met, one path for each draw.

        Parameters
        ----------
        measured : (draws, tests, n)
        along : steps along the times
        which : (times,) test at each time, −1 for none
        rng : source of randomness
        """
        seen = (which >= 0)[None, :, None]
        precision = self.precision[:, which] * seen[..., None]
        course = simulate(along, rng)
        # Noise of covariance Λ: its Cholesky factor is that of the inverse covariance.
        noise = rng.standard_normal(course.states.shape)[..., None]
        noise = np.matmul(np.linalg.cholesky(self.precision)[:, which], noise)[..., 0]
        off = measured[:, which] - course.states
        beyond = (np.matmul(precision, off[..., None])[..., 0] - noise) * seen
        return course.corrected(correct(along, precision, beyond))
