"""Draws of a linearised loop put back on the bent ridge of its likelihood.

A loop fixes a few combinations of its parameters sharply (see `ridge_coordinates`). A Gaussian in
the parameters' own coordinates follows such a ridge along its tangent and leaves it after a short
way: secant stiffness then scatters tens of times too far. In the ridge coordinates r the loop's
likelihood is nearly Gaussian. A draw x, at r(x*) + R(x − x*) by the tangent, is therefore moved to
the x' that minimises

    |r(x') − r(x*) − R(x − x*)|² weighted by the loop  +  |x' − x|² weighted by the loop prior,

by Gauss-Newton steps: along what the loop fixes it returns to the ridge, elsewhere it stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hdprog.inference.ridge_coordinates import from_unconstrained
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.evidence import Linearised
from hdprog.trend.wear_coordinates import to_loop

_COUNT = len(NAMES)
_DIFFERENCE = 1e-5
_STEPS = 5
_LARGEST_STEP = 1.0  # prior spreads of a coordinate in one step


@dataclass(frozen=True)
class Bend:
    """The ridge of one loop around its point of linearisation.

    Attributes
    ----------
    point : (n,) x*, in wear coordinates; amplitudes of effects behind the eight are no part of it
    loop : linearised there
    spread : (n,) standard deviations of the loop prior
    alpha : gear-tooth angle in rad
    softplus_scale : scale in Nm of the coordinate of T_T
    """

    point: FloatArray
    loop: Linearised
    spread: FloatArray
    alpha: float
    softplus_scale: float

    def correction(self, measured: FloatArray) -> FloatArray:
        """Compute what to add to draws (draws, n) of what the test met, same shape."""
        centre, tangent = self._ridge(self.point[None])
        if not np.isfinite(tangent).all():
            # Teeth that are all met at no torque at all leave no ridge to follow.
            return np.zeros_like(measured)
        inverse = np.linalg.inv(tangent[0])
        weight = inverse.T @ self.loop.precision @ inverse
        target = centre + (measured - self.point) @ tangent[0].T
        keep = np.diag(self.spread**-2.0)
        found = measured.copy()
        with np.errstate(all="ignore"):
            ridge, slope = self._ridge(found)
            cost = first = self._cost(found, measured, ridge - target, weight)
            for _ in range(_STEPS):
                pulled = np.swapaxes(slope, -1, -2) @ weight
                right = pulled @ (target - ridge)[..., None]
                right -= ((found - measured) * self.spread**-2.0)[..., None]
                matrix = np.nan_to_num(pulled @ slope, posinf=0.0, neginf=0.0) + keep
                step = np.linalg.solve(matrix, np.nan_to_num(right))[..., 0]
                longest = np.max(np.abs(step) / self.spread, axis=1, keepdims=True)
                step *= np.minimum(1.0, _LARGEST_STEP / np.maximum(longest, 1e-12))
                trial = found + step
                trial_ridge, trial_slope = self._ridge(trial)
                trial_cost = self._cost(trial, measured, trial_ridge - target, weight)
                better = trial_cost < cost
                found = np.where(better[:, None], trial, found)
                ridge = np.where(better[:, None], trial_ridge, ridge)
                slope = np.where(better[:, None, None], trial_slope, slope)
                cost = np.where(better, trial_cost, cost)
        settled = np.isfinite(first) & np.isfinite(cost)
        return np.where(settled[:, None], found - measured, 0.0)

    def _cost(
        self, found: FloatArray, measured: FloatArray, off: FloatArray, weight: FloatArray
    ) -> FloatArray:
        moved = (found - measured) / self.spread
        return np.asarray(np.einsum("di,ij,dj->d", off, weight, off) + np.sum(moved**2, axis=1))

    def _ridge(self, wear: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Ridge coordinates (draws, n) and their derivative (draws, n, n)."""
        own, size = wear[:, :_COUNT], wear.shape[1]
        shift = _DIFFERENCE * np.eye(_COUNT)
        around = np.concatenate([own[None], own + shift[:, None], own - shift[:, None]])
        flat = from_unconstrained(
            to_loop(around.reshape(-1, _COUNT)), self.alpha, self.softplus_scale
        ).reshape(around.shape)
        derivative = np.tile(np.eye(size), (len(wear), 1, 1))
        differences = (flat[1 : _COUNT + 1] - flat[_COUNT + 1 :]) / (2 * _DIFFERENCE)
        derivative[:, :_COUNT, :_COUNT] = np.moveaxis(differences, 0, -1)
        return np.concatenate([flat[0], wear[:, _COUNT:]], axis=1), derivative
