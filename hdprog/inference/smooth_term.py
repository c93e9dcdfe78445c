"""An empirical smooth term over one coordinate: a Gaussian process in a basis of cosines.

Matérn covariance of order 3/2 in its Hilbert-space approximation (Solin and Särkkä, Statistics and
Computing 30 (2020) 419): features √2 cos(π j x) with variances that follow the spectral density.
Over `branch` the rising and the falling stretches have a function each; over the distance or the
time since a reversal the function changes sign with the direction of torque.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hdprog.physics.coordinates import coordinates
from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

FEATURES = 72
LENGTHS: tuple[float, ...] = (0.3, 0.1, 0.035, 0.015)
"""Correlation lengths, in parts of the range."""
_MARGIN = 0.05
_ODD = ("distance_since_reversal", "time_since_reversal")


@dataclass(frozen=True, eq=False)
class SmoothTerm:
    """A term of unknown origin.

    Attributes
    ----------
    coordinate : name in `coordinates`
    low, high : range of the coordinate on the record
    spread : (FEATURES,) standard deviations a priori of the cosines, in units of the noise scale,
        in rad; a size times `spectrum` for one Matérn covariance
    """

    coordinate: str
    low: float
    high: float
    spread: FloatArray

    def features(self, course: Course) -> FloatArray:
        """(samples, k) columns B with covariance B Bᵀ in rad², up to the noise scale."""
        basis = basis_of(self.coordinate, self.low, self.high, course)
        return np.asarray(basis * np.tile(self.spread, basis.shape[1] // FEATURES))


def basis_of(coordinate: str, low: float, high: float, course: Course) -> FloatArray:
    """(samples, k) cosines of a coordinate, scaled to fill most of 0 … 1."""
    values = coordinates(course)[coordinate]
    x = _MARGIN + (1 - 2 * _MARGIN) * np.clip((values - low) / (high - low), 0.0, 1.0)
    basis = np.sqrt(2) * np.cos(np.pi * np.outer(x, np.arange(1, FEATURES + 1)))
    direction = course.path.direction[:, None]
    if coordinate == "branch":
        return np.asarray(np.hstack([basis * (direction > 0), basis * (direction < 0)]))
    return np.asarray(basis * direction if coordinate in _ODD else basis)


def spectrum(length: float) -> FloatArray:
    """(FEATURES,) standard deviations of the cosines for a length, squares summing to one."""
    frequency = np.pi * np.arange(1, FEATURES + 1)
    density = (3 / length**2 + frequency**2) ** -2.0
    return np.asarray(np.sqrt(density / density.sum()))
