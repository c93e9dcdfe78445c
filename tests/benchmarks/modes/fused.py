"""hdprog's likelihood in one compiled loop, some ten times as fast, for references that need it.

The same arithmetic as `LoopLikelihood.log_likelihood` of a drive model without effects; `compiled`
compares the two over draws of the prior and refuses a difference.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np

from hdprog.inference.likelihood import LoopLikelihood
from hdprog.physics.parameters import FloatArray

LogLikelihood = Callable[[FloatArray], FloatArray]
LARGEST_DIFFERENCE = 1e-6
"""In log L, where the values themselves reach some thousands."""
_COMPARED = 2000


def compiled(likelihood: LoopLikelihood, rng: np.random.Generator) -> LogLikelihood:
    """The log-likelihood (draws,) of points (draws, 9); −inf outside the hard support.

    Parameters
    ----------
    likelihood : of the drive model alone
    rng : for the points at which the two are compared

    Raises
    ------
    ValueError
        if it differs from hdprog's
    """
    if likelihood.effects:
        raise ValueError("the compiled likelihood knows no effects: fit the drive model alone")
    path, noise = likelihood.reduced.path, likelihood.noise
    white = noise.whitening is None
    arguments = (
        likelihood.prior.softplus_scale,
        likelihood.alpha,
        np.ascontiguousarray(path.torque),
        np.zeros(path.torque.size) if path.variance is None else path.variance,
        path.direction,
        path.starts.astype(np.int64),
        path.ends.astype(np.int64),
        np.ascontiguousarray(path.reached),
        1 / noise.sd,
        np.zeros((1, 1)) if noise.whitening is None else np.ascontiguousarray(noise.whitening.T),
        white,
        likelihood.project(likelihood.reduced.angle[None, :])[0],
        _offset_direction(likelihood),
        float(likelihood.degrees),
    )
    batch = _batch()

    def log_likelihood(points: FloatArray) -> FloatArray:
        return np.asarray(batch(np.ascontiguousarray(points), arguments))

    points = np.column_stack(
        [likelihood.prior.sample(_COMPARED, rng), rng.logistic(size=_COMPARED)]
    )
    inside = likelihood.supported(points)
    found = log_likelihood(points)
    difference = np.abs(found[inside] - likelihood.log_likelihood(points[inside])).max()
    if not (difference < LARGEST_DIFFERENCE and np.isneginf(found[~inside]).all()):
        raise ValueError(f"the compiled likelihood is off hdprog's by {difference:g}")
    return log_likelihood


def _offset_direction(likelihood: LoopLikelihood) -> FloatArray:
    ones = likelihood.noise.whiten(np.ones((1, likelihood.blocks)))[0]
    return np.asarray(ones / np.linalg.norm(ones))


@lru_cache(maxsize=1)
def _batch() -> Any:
    numba = import_module("numba")
    envelope = numba.njit(_envelope)
    one = numba.njit(_one_for(envelope))

    def batch(points, arguments):  # type: ignore[no-untyped-def]
        found = np.empty(len(points))
        for index in range(len(points)):
            found[index] = one(points[index], *arguments)
        return found

    return numba.njit(batch)


def _envelope(u, s, k, mu, m, T_i, K_W):  # type: ignore[no-untyped-def]
    """Slip that pushes at one torque u, as `slip_envelope` has it."""
    friction = max(m * (abs(u) - T_i), 0.0)
    drawn_back = min(u * (s + mu * k) - friction, 0.0) / (K_W * (k - mu * s))
    return drawn_back + max(u * (s - mu * k) - friction, 0.0) / (K_W * (k + mu * s))


def _one_for(envelope: Any) -> Any:
    """The log-likelihood of one point (9,), to be compiled."""

    def one(  # type: ignore[no-untyped-def]
        point,
        softplus_scale,
        alpha,
        torque,
        variance,
        direction,
        starts,
        ends,
        reached,
        inverse_sd,
        whitening,
        white,
        data,
        offset,
        degrees,
    ):
        K_F, K_W, a, b = np.exp(point[:4])
        T_T = softplus_scale * (max(point[4], 0.0) + math.log1p(math.exp(-abs(point[4]))))
        c, T_i, mu = -math.exp(point[5]), math.exp(point[6]), math.exp(point[7])
        s, k, tangent, m = math.sin(alpha), math.cos(alpha), math.tan(alpha), mu * c
        if not (mu < min(tangent, 1 / tangent) and s + mu * (k + c) > 0):
            return -np.inf
        fraction = 1 / (1 + math.exp(-point[8]))
        lower = envelope(torque[0], s, k, mu, m, T_i, K_W)
        upper = -envelope(-torque[0], s, k, mu, m, T_i, K_W)
        slip = lower + fraction * (upper - lower)
        straight = a * T_T < 1e-9 * b
        angle = np.empty(torque.size)
        for stretch in range(starts.size):
            sign = direction[starts[stretch]]
            held = sign * slip
            for block in range(starts[stretch], ends[stretch]):
                pushed = envelope(sign * torque[block], s, k, mu, m, T_i, K_W)
                size = abs(torque[block])
                meshing = min(size, T_T)
                mesh = meshing / b if straight else math.log1p(meshing * (a / b)) / a
                mesh += (size - meshing) / (a * T_T + b)
                if size < T_T:
                    mesh -= 0.5 * variance[block] * a / (a * size + b) ** 2
                angle[block] = sign * max(pushed, held) * tangent + torque[block] / K_F
                angle[block] += mesh * np.sign(torque[block])
            end = envelope(sign * reached[stretch], s, k, mu, m, T_i, K_W)
            slip = sign * max(end, held)
        whitened = angle * inverse_sd if white else np.dot(whitening, angle)
        squares, along = 0.0, 0.0
        for block in range(torque.size):
            left = data[block] - whitened[block]
            squares += left * left
            along += left * offset[block]
        return -0.5 * degrees * math.log(squares - along * along)

    return one
