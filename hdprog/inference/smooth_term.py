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
_MARGIN = 0.05
_ODD = ("distance_since_reversal", "time_since_reversal")


@dataclass(frozen=True)
class SmoothTerm:
    """A term of unknown origin.

    Attributes
    ----------
    coordinate : name in `coordinates`
    low, high : range of the coordinate on the record
    sd : standard deviation a priori in units of the noise scale, in rad
    length : correlation length in parts of the range
    """

    coordinate: str
    low: float
    high: float
    sd: float
    length: float

    def features(self, course: Course) -> FloatArray:
        """(samples, k) columns B with covariance B Bᵀ in rad², up to the noise scale."""
        basis = basis_of(self.coordinate, self.low, self.high, course)
        repeated = basis.shape[1] // FEATURES
        return np.asarray(self.sd * basis * np.tile(spectrum(self.length), repeated))


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
    """(FEATURES,) standard deviations of the cosines, squares summing to one."""
    frequency = np.pi * np.arange(1, FEATURES + 1)
    density = (3 / length**2 + frequency**2) ** -2.0
    return np.asarray(np.sqrt(density / density.sum()))
