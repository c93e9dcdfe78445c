"""A test's own likelihood, where its linearisation is not exact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hdprog.physics.parameters import FloatArray

_SHRINKAGE = 0.05  # of slopes and correlations that are learnt from draws
_LEAST_VARIANCE = 1e-8


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

    @staticmethod
    def fitted(departure: FloatArray, met: FloatArray) -> Nuisances:
        """From draws of nuisances (draws, k) and of x − x* (draws, n): regression, shrunk."""
        off = departure - departure.mean(axis=0)
        spread = np.maximum(off.std(axis=0), np.finfo(float).tiny)
        scaled = off / spread
        mean, count = met.mean(axis=0), len(met)
        ridge = scaled.T @ scaled + _SHRINKAGE * count * np.eye(off.shape[1])
        effect = np.linalg.solve(ridge, scaled.T @ (met - mean))
        slope = (effect / spread[:, None]).T
        left = met - mean - off @ slope.T
        covariance = left.T @ left / count
        covariance *= 1.0 - _SHRINKAGE * (1.0 - np.eye(met.shape[1]))
        covariance += _LEAST_VARIANCE * np.eye(met.shape[1])
        return Nuisances(
            mean - slope @ departure.mean(axis=0), slope, np.asarray(np.linalg.inv(covariance))
        )

    def deviates(self, departure: FloatArray, nuisances: FloatArray) -> FloatArray:
        """Standard normal deviates (draws, k) from which `draw` makes these nuisances."""
        off = nuisances - self.mean - departure @ self.slope.T
        return np.asarray(off @ np.linalg.cholesky(self.precision))

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

    def log_likelihood(self, coordinates: FloatArray, nuisances: FloatArray) -> FloatArray:
        """(draws,) at coordinates (draws, n) and nuisances (draws, k); −inf outside the support.

        Up to one constant.
        """
        ...

    def own_at(self, coordinates: FloatArray) -> FloatArray:
        """Mode (k,) of the test's own numbers at coordinates (n,)."""
        ...


class ExactEvidence(Protocol):
    """A test that knows its likelihood."""

    def about(self, coordinates: FloatArray) -> tuple[ExactLikelihood, Nuisances]:
        """The likelihood, in own numbers that suit coordinates and amplitudes (n,) nearby.

        And those numbers' Gaussian there.
        """
        ...
