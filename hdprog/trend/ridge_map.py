"""From the tangent of a loop's ridge onto the ridge.

A loop fixes a few combinations of its parameters sharply (see `ridge_coordinates`). A Gaussian in
the parameters' own coordinates follows such a ridge along its tangent and leaves it after a short
way: secant stiffness then scatters tens of times too far. In the ridge coordinates r the loop's
likelihood is nearly Gaussian. A draw u, at r(x*) + R(u − x*) by the tangent, therefore stands for
the x whose ridge coordinates are these: a map one to one, with a density.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.wear_coordinates import from_loop, slope, to_loop

_COUNT = len(NAMES)
_DIFFERENCE = 1e-5
_MOST_OF_CUP = 0.98  # of the compliance beside the wave generator's


@dataclass(frozen=True)
class RidgeMap:
    """The ridge of one loop around its point of linearisation.

    Attributes
    ----------
    point : (n,) x*, in wear coordinates; amplitudes of effects behind the eight are no part of it
    alpha : gear-tooth angle in rad
    softplus_scale : scale in Nm of the coordinate of T_T
    """

    point: FloatArray
    alpha: float
    softplus_scale: float

    def with_cup(self, log_stiffness: float) -> FloatArray:
        """The point's like (n,) on its ridge with another log K_F, K_F in Nm/rad.

        What the loop fixes stays as it is. A cup that is too soft for the loop's compliance takes
        all but the last of it, and leaves the teeth next to none. Without a ridge the point stays.
        """
        own = to_loop(self.point)[None, :_COUNT]
        with np.errstate(all="ignore"):
            ridge = from_unconstrained(own, self.alpha, self.softplus_scale)[0]
            compliance, wave_generator = ridge[0], ridge[1]
            log_rest = compliance - np.logaddexp(0.0, wave_generator)
            share = min(float(np.exp(-log_stiffness - log_rest)), _MOST_OF_CUP)
            ridge[2] = np.log(share / (1.0 - share))
            found, slopes = to_unconstrained(ridge[None], self.alpha, self.softplus_scale)
        other = self.point.copy()
        if np.isfinite(slopes).all():
            other[:_COUNT] = from_loop(found)[0]
        return other

    def tangents_of(self, met: FloatArray) -> FloatArray:
        """Points of the tangent that stand for wear coordinates, (draws, n); see `onto_ridges`.

        Without a ridge these themselves; not finite where they lie on none.
        """
        if self.inverse is None:
            return met
        centre, _ = self.ridge
        tangents = met.copy()
        with np.errstate(all="ignore"):
            own = to_loop(met)[:, :_COUNT]
            flat = from_unconstrained(own, self.alpha, self.softplus_scale)
            tangents[:, :_COUNT] = self.point[:_COUNT] + (flat - centre) @ self.inverse.T
        return tangents

    @cached_property
    def ridge(self) -> tuple[FloatArray, FloatArray]:
        """Ridge coordinates (8,) of the point and their derivative (8, 8)."""
        own = self.point[:_COUNT]
        shift = _DIFFERENCE * np.eye(_COUNT)
        around = np.concatenate([own[None], own + shift, own - shift])
        with np.errstate(all="ignore"):
            flat = from_unconstrained(to_loop(around), self.alpha, self.softplus_scale)
            derivative = (flat[1 : _COUNT + 1] - flat[_COUNT + 1 :]) / (2 * _DIFFERENCE)
        return flat[0], derivative.T

    @cached_property
    def inverse(self) -> FloatArray | None:
        """(8, 8) derivative of the wear coordinates by those of the ridge; None without a ridge."""
        _, derivative = self.ridge
        return np.asarray(np.linalg.inv(derivative)) if np.isfinite(derivative).all() else None


def onto_ridges(maps: Sequence[RidgeMap], tangents: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Wear coordinates of draws on the tangents of several loops' ridges.

    Loops without a ridge, whose teeth are all met at no torque at all, stay on their tangents.

    Parameters
    ----------
    maps : of the loops; tooth angle and scale of T_T are those of all
    tangents : (draws, loops, n)

    Returns
    -------
    (draws, loops, n) and (draws, loops) log |det| of their derivative, up to a constant; −inf, and
    the draw itself, where no parameters lie on the ridge there
    """
    points = np.stack([one.point[:_COUNT] for one in maps])
    centres, derivatives = (np.stack(parts) for parts in zip(*(m.ridge for m in maps), strict=True))
    has_ridge = np.isfinite(derivatives).all(axis=(1, 2))
    with np.errstate(all="ignore"):
        along = np.matmul(derivatives, (tangents[..., :_COUNT] - points)[..., None])[..., 0]
        flat = (centres + along).reshape(-1, _COUNT)
        loop, log_slope = to_unconstrained(flat, maps[0].alpha, maps[0].softplus_scale)
        wear = from_loop(loop)
        log_slope = log_slope - np.log(slope(wear)).sum(axis=1)
    shape = tangents.shape[:2]
    inside = (np.isfinite(log_slope) & np.isfinite(wear).all(axis=1)).reshape(shape)
    found = tangents.copy()
    moves = (inside & has_ridge)[..., None]
    np.copyto(found[..., :_COUNT], wear.reshape(*shape, _COUNT), where=moves)
    off_ridge = np.where(has_ridge, -np.inf, 0.0)
    return found, np.where(moves[..., 0], log_slope.reshape(shape), off_ridge)
