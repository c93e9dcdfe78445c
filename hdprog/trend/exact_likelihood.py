"""A test's own likelihood, where its linearisation is not exact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class Nuisances:
    """Gaussian of a test's own numbers, given the state's numbers x near a point x*.

    Mean `mean` + `slope`·(x − x*), precision `precision`, prior N(0, I) included.

    Attributes
    ----------
    mean : (k,)
    slope : (k, n)
    precision : (k, k)
    """

    mean: FloatArray
    slope: FloatArray
    precision: FloatArray

    @staticmethod
    def none(state: int) -> Nuisances:
        """No numbers beside a state of so many."""
        return Nuisances(np.zeros(0), np.zeros((0, state)), np.zeros((0, 0)))

    def draw(self, departure: FloatArray, deviates: FloatArray) -> FloatArray:
        """Nuisances (draws, k) at x − x* (draws, n) from standard normal deviates (draws, k)."""
        lower = np.linalg.cholesky(self.precision)
        spread = np.linalg.solve(lower.T, deviates.T).T
        return np.asarray(self.mean + departure @ self.slope.T + spread)

    def log_density(self, departure: FloatArray, nuisances: FloatArray) -> FloatArray:
        """(draws,) up to a constant, of nuisances (draws, k) at x − x* (draws, n)."""
        off = nuisances - self.mean - departure @ self.slope.T
        return np.asarray(-0.5 * np.einsum("di,ij,dj->d", off, self.precision, off))


class ExactLikelihood(Protocol):
    """Likelihood of the state's numbers and of a test's own, which have the prior N(0, I)."""

    def nuisances(self, coordinates: FloatArray) -> Nuisances:
        """The test's own numbers near coordinates and amplitudes (n,)."""
        ...

    def log_likelihood(self, coordinates: FloatArray, nuisances: FloatArray) -> FloatArray:
        """(draws,) at coordinates (draws, n) and nuisances (draws, k); −inf outside the support.

        Up to one constant.
        """
        ...
