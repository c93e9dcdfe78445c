"""Posterior of nonnegative weights with Gaussian noise of unknown scale, sampled exactly.

Given the scale s, the weights are Gaussian, cut off at zero; given the weights, s² is a scaled
inverse χ². The weights are drawn by exact Hamiltonian dynamics: in whitened coordinates a particle
follows an ellipse for a quarter of its period and bounces off the walls, which leaves the cut-off
Gaussian unchanged without any rejection (Pakman & Paninski, J. Comput. Graph. Stat. 23 (2014) 518).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

from hdprog.physics.parameters import FloatArray

_QUARTER = np.pi / 2
_MOST_BOUNCES = 20_000


def sample_weights(
    data: FloatArray,
    design: FloatArray,
    degrees: float,
    start: FloatArray,
    draws: int,
    rng: np.random.Generator,
) -> FloatArray:
    """One chain of weights x ≥ 0 with data = design·x + s·e, x half-normal and 1/s² on s².

    Parameters
    ----------
    data, design : (rows,) and (rows, size), whitened, the offset taken out
    degrees : of freedom of the noise scale
    start : (size,) first weights, nonnegative
    draws : length of the chain
    rng : source of randomness

    Returns
    -------
    (draws, size)
    """
    information, pull = design.T @ design, design.T @ data
    found = np.empty((draws, start.size))
    weights = np.maximum(start, 1e-9)  # a particle on a wall has no way in
    for index in range(draws):
        left = data - design @ weights
        variance = float(left @ left / rng.chisquare(degrees))
        weights = quarter_turn(
            information / variance + np.eye(start.size), pull / variance, weights, rng
        )
        found[index] = weights
    return found


def quarter_turn(
    precision: FloatArray, pull: FloatArray, weights: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Next weights (size,) of a Gaussian with precision·mean = pull, cut off at zero."""
    factor = np.linalg.cholesky(precision)  # precision = L Lᵀ; weights = mean + L⁻ᵀ·z
    mean = solve_triangular(factor.T, solve_triangular(factor, pull, lower=True))
    walls = solve_triangular(factor, np.eye(weights.size), lower=True).T
    between = walls @ walls.T
    norms = np.diag(between)
    # Heights over the walls and their velocities say all: z itself is not needed.
    height = weights - mean
    velocity = walls @ rng.standard_normal(weights.size)
    left = _QUARTER
    for _ in range(_MOST_BOUNCES):
        swing = np.hypot(velocity, height)
        phase = np.arctan2(-velocity, height)
        with np.errstate(invalid="ignore"):
            when = np.mod(np.arccos(-mean / swing) - phase, 2 * np.pi)
        when = np.where(np.isnan(when) | (when < 1e-12), np.inf, when)
        wall = int(np.argmin(when))
        time = min(float(when[wall]), left)
        sine, cosine = np.sin(time), np.cos(time)
        height, velocity = velocity * sine + height * cosine, velocity * cosine - height * sine
        left -= time
        if left <= 0:
            break
        velocity = velocity - 2 * velocity[wall] / norms[wall] * between[:, wall]
    return np.asarray(np.maximum(mean + height, 0.0))
