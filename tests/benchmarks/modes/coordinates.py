"""Coordinate systems in which the reference moves its particles, with their Jacobians.

A move that is straight in one system follows a ridge that is bent in another. Any of them leaves
the posterior unchanged if its Jacobian is right; `jacobian_error` finds that out by differences.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained
from hdprog.physics.parameters import NAMES, FloatArray

XI_SCALE = 0.02  # that hdprog's ridge coordinates count ξ in
RIDGE = ("log C", "logit p_W", "logit p_F", "log D", "T_T", "log m", "ξ", "log P")
"""Names of hdprog's ridge coordinates; that of T_T is the parameter's own."""
_STEP = 1e-6
_MU = NAMES.index("mu")


@dataclass(frozen=True)
class Plain:
    """The points of the likelihood themselves."""

    def forward(self, points: FloatArray) -> FloatArray:
        """(draws, 9) of points (draws, 9)."""
        return points

    def backward(self, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (draws, 9), and log |det| (draws,) of their derivative by the position."""
        return position, np.zeros(len(position))


@dataclass(frozen=True)
class Sheared:
    """hdprog's ridge coordinates with up to three of them exchanged.

    Attributes
    ----------
    alpha, softplus_scale : of the drive and its prior
    rest : log of the compliance without the wave generator's instead of log C, which is what a
        record fixes whose torque never makes it slip back
    breakaway : sign of the slip's logit whose log sigmoid is added to log P: from a slip between
        the envelopes, torque must travel by 2 P q or 2 P (1 − q) to the nearest one
    friction : log μ instead of ξ, whose prior is a wedge where a record says little of friction
    """

    alpha: float
    softplus_scale: float
    rest: bool = False
    breakaway: int = 0
    friction: bool = False

    def forward(self, points: FloatArray) -> FloatArray:
        """(draws, 9) of points (draws, 9)."""
        ridge = from_unconstrained(points[:, :COUNT], self.alpha, self.softplus_scale)
        position = np.column_stack([ridge, points[:, COUNT:]])
        position[:, 0] += self.rest * _log_sigmoid(-position[:, 1])
        position[:, 7] += abs(self.breakaway) * _log_sigmoid(self.breakaway * position[:, 8])
        if self.friction:
            position[:, 6] = points[:, _MU]
        return position

    def backward(self, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (draws, 9), and log |det| (draws,) of their derivative by the position."""
        ridge = position.copy()
        ridge[:, 0] -= self.rest * _log_sigmoid(-ridge[:, 1])
        ridge[:, 7] -= abs(self.breakaway) * _log_sigmoid(self.breakaway * ridge[:, 8])
        # hdprog leaves the constant factor of ξ out.
        log_jacobian = np.full(len(ridge), math.log(XI_SCALE / math.cos(self.alpha)))
        if self.friction:
            cosine = math.cos(self.alpha)
            with np.errstate(over="ignore", invalid="ignore"):
                ridge[:, 6] = (np.exp(ridge[:, 5]) - cosine * np.exp(position[:, 6])) / XI_SCALE
            log_jacobian += math.log(cosine / XI_SCALE) + position[:, 6]
        points, log_ridge = to_unconstrained(ridge[:, :COUNT], self.alpha, self.softplus_scale)
        return np.column_stack([points, ridge[:, COUNT:]]), log_jacobian + log_ridge


System = Plain | Sheared


def systems(likelihood: LoopLikelihood) -> list[System]:
    """The systems that the moves take turns in."""
    alpha, scale = likelihood.alpha, likelihood.prior.softplus_scale
    return [
        Plain(),
        Sheared(alpha, scale),
        Sheared(alpha, scale, rest=True, breakaway=1),
        Sheared(alpha, scale, rest=True, breakaway=-1, friction=True),
    ]


def ridge(likelihood: LoopLikelihood, points: FloatArray) -> FloatArray:
    """hdprog's ridge coordinates (draws, 8) of points (draws, 9)."""
    return from_unconstrained(points[:, :COUNT], likelihood.alpha, likelihood.prior.softplus_scale)


def jacobian_error(system: System, points: FloatArray) -> float:
    """Largest error of a system's log Jacobian at points (draws, 9), by central differences.

    The forward map is differentiated: it is the map that the proposals' geometry comes from, and
    the one that the backward map's own formula was not derived with.
    """
    size = points.shape[1]
    steps = _STEP * np.vstack([np.eye(size), -np.eye(size)])
    near = system.forward((points[:, None, :] + steps).reshape(-1, size)).reshape(-1, 2, size, size)
    derivative = (near[:, 0] - near[:, 1]) / (2 * _STEP)
    numeric = -np.linalg.slogdet(derivative)[1]
    back, exact = system.backward(system.forward(points))
    return float(max(np.abs(exact - numeric).max(), np.abs(back - points).max()))


def _log_sigmoid(value: FloatArray) -> FloatArray:
    return np.asarray(-np.logaddexp(0.0, -value))
