"""The trend where it is known what every test met: its density, and the states behind it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray
from hdprog.trend.smoother import Predictor, correct, simulate
from hdprog.trend.state_space import Steps


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
    ) -> tuple[FloatArray, FloatArray]:
        """Draw states given what the tests met, one path for each draw.

        Parameters
        ----------
        measured : (draws, tests, n)
        along : steps along the times
        which : (times,) test at each time, −1 for none
        rng : source of randomness

        Returns
        -------
        states (draws, times, n), and what the last carries
        """
        seen = (which >= 0)[None, :, None]
        precision = self.precision[:, which] * seen[..., None]
        states, carried = simulate(along, rng)
        # Noise of covariance Λ: its Cholesky factor is that of the inverse covariance.
        noise = rng.standard_normal(states.shape)[..., None]
        noise = np.matmul(np.linalg.cholesky(self.precision)[:, which], noise)[..., 0]
        off = measured[:, which] - states
        beyond = (np.matmul(precision, off[..., None])[..., 0] - noise) * seen
        found = correct(along, precision, beyond)
        return states + found[0], carried + found[1]
