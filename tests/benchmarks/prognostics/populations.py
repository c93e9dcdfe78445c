"""Populations of a law as points of a normal space, and many of them at once.

The prior of laws.py is four independent standard normal coordinates: those of pace, scatter, noise
and shape, in this order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from tests.benchmarks.prognostics.laws import FloatArray, Law, Population

COORDINATES = 4


@dataclass(frozen=True)
class Populations:
    """Populations of one law.

    Attributes
    ----------
    law : which
    pace, scatter, noise, shape : (populations,) as in `laws.Population`
    """

    law: Law
    pace: FloatArray
    scatter: FloatArray
    noise: FloatArray
    shape: FloatArray

    def __getitem__(self, at: int) -> Population:
        return self.law.kind(
            float(self.pace[at]),
            float(self.scatter[at]),
            float(self.noise[at]),
            float(self.shape[at]),
        )


def populations_at(law: Law, points: FloatArray) -> Populations:
    """Populations at points (populations, 4) of the normal space, as `laws.Law` draws them."""
    pace = np.exp(0.15 * points[:, 0])
    share = ndtr(points[:, 1:])
    shape = law.least + share[:, 2] * (law.largest - law.least)
    if law.logarithmic:
        shape = law.least * (law.largest / law.least) ** share[:, 2]
    return Populations(law, pace, 0.1 + 0.15 * share[:, 0], 0.005 * 6.0 ** share[:, 1], shape)
