"""Priors of the physical parameters: independent Gaussians in the unconstrained coordinates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from hdprog.physics.parameters import BY_NAME, NAMES, FloatArray, Parameters


@dataclass(frozen=True)
class Prior:
    """Prior of the eight parameters.

    Attributes
    ----------
    name : name of the file in priors/, or a path
    mean, sd : (8,) in the unconstrained coordinates, in the order of `NAMES`
    softplus_scale : scale in Nm of the coordinate of T_T
    source : where the numbers come from, in words
    catalogue : maker's figures by name (T1_Nm, T2_Nm, K1_Nm_per_rad, …); may be empty
    """

    name: str
    mean: FloatArray
    sd: FloatArray
    softplus_scale: float
    source: str
    catalogue: Mapping[str, float] = field(default_factory=dict)

    def to_physical(self, coordinates: FloatArray) -> Parameters:
        """Parameters by name, each (...), from unconstrained coordinates (..., 8)."""
        exponential = np.exp(coordinates)  # of all at once; a few numbers cost as much as one
        found: dict[str, FloatArray] = {}
        for index, name in enumerate(NAMES):
            transform = BY_NAME[name].transform
            if transform == "softplus":
                found[name] = BY_NAME[name].from_coordinate(
                    coordinates[..., index], self.softplus_scale
                )
            else:
                value = exponential[..., index]
                found[name] = -value if transform == "negative_log" else value
        return found

    def log_density(self, coordinates: FloatArray) -> FloatArray:
        """Log prior density (...) up to a constant at coordinates (..., 8)."""
        deviation = (coordinates - self.mean) / self.sd
        return np.asarray(-0.5 * np.einsum("...i,...i->...", deviation, deviation))

    def sample(self, size: int, rng: np.random.Generator) -> FloatArray:
        """Draws (size, 8) of the coordinates; the hard support is the caller's to apply."""
        return self.mean + self.sd * rng.standard_normal((size, len(NAMES)))

    @property
    def catalogue_torques(self) -> tuple[float, float] | None:
        """T1 and T2 in Nm of the maker's piecewise-linear stiffness, if the file gives them."""
        if "T1_Nm" in self.catalogue and "T2_Nm" in self.catalogue:
            return self.catalogue["T1_Nm"], self.catalogue["T2_Nm"]
        return None


@dataclass(frozen=True)
class RecordScales:
    """Scales of a measured record that a generic prior is centred on.

    Attributes
    ----------
    secant_stiffness : span of torque over span of angle, Nm/rad
    largest_torque : Nm
    """

    secant_stiffness: float
    largest_torque: float

    @staticmethod
    def of(torque: FloatArray, angle: FloatArray) -> RecordScales:
        """Scales of a record; torque in Nm and angle in rad, (samples,) each."""
        return RecordScales(float(np.ptp(torque) / np.ptp(angle)), float(np.max(np.abs(torque))))

    def factor(self, name: str) -> float:
        """The scale with that name in a prior file."""
        return {
            "secant_stiffness": self.secant_stiffness,
            "largest_torque": self.largest_torque,
            "secant_stiffness_per_torque": self.secant_stiffness / self.largest_torque,
        }[name]


def log_median(name: str, median: float) -> float:
    """Coordinate of a median value of a log or negative-log parameter."""
    return math.log(-median if BY_NAME[name].transform == "negative_log" else median)


@cache
def even_draws(binary_log: int) -> FloatArray:
    """Evenly spread standard normal draws (2**binary_log, 8): the same on every machine."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    uniform = qmc.Sobol(len(NAMES), scramble=False).random_base2(binary_log)
    return np.asarray(ndtri(uniform + 0.5 / len(uniform)))
