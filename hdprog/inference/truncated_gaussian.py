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
    """Chains of weights x ≥ 0 with data = design·x + s·e, x half-normal and 1/s² on s².

    Parameters
    ----------
    data, design : (rows,) and (rows, size), whitened, the offset taken out
    degrees : of freedom of the noise scale
    start : (chains, size) first weights, nonnegative
    draws : length of the chains
    rng : source of randomness

    Returns
    -------
    (chains, draws, size)
    """
    chains, size = start.shape
    information, pull = design.T @ design, design.T @ data
    found = np.empty((chains, draws, size))
    weights = np.maximum(start, 1e-9)  # a particle on a wall has no way in
    for index in range(draws):
        left = data - weights @ design.T
        variance = (left**2).sum(axis=1) / rng.chisquare(degrees, chains)
        precision = information / variance[:, None, None] + np.eye(size)
        weights = quarter_turn(precision, pull / variance[:, None], weights, rng)
        found[:, index] = weights
    return found


def quarter_turn(
    precision: FloatArray, pull: FloatArray, weights: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Next weights of Gaussians with precision·mean = pull, cut off at zero.

    Parameters
    ----------
    precision : (chains, size, size)
    pull, weights : (chains, size)
    rng : source of randomness

    Returns
    -------
    (chains, size)
    """
    chains, size = weights.shape
    every = np.arange(chains)
    factor = np.linalg.cholesky(precision)  # precision = L Lᵀ; weights = mean + L⁻ᵀ·z
    walls = np.array([solve_triangular(one, np.eye(size), lower=True).T for one in factor])
    between = walls @ walls.transpose(0, 2, 1)
    mean = np.linalg.solve(precision, pull[:, :, None])[:, :, 0]
    # Heights over the walls and their velocities say all: z itself is not needed.
    height = weights - mean
    velocity = np.einsum("cij,cj->ci", walls, rng.standard_normal((chains, size)))
    left = np.full(chains, _QUARTER)
    for _ in range(_MOST_BOUNCES):
        swing = np.hypot(velocity, height)
        phase = np.arctan2(-velocity, height)
        with np.errstate(invalid="ignore"):
            when = np.mod(np.arccos(-mean / swing) - phase, 2 * np.pi)
        when[~(when >= 1e-12)] = np.inf  # a wall that is not reached, or left this moment
        wall = when.argmin(axis=1)
        time = np.minimum(when[every, wall], left)
        sine, cosine = np.sin(time)[:, None], np.cos(time)[:, None]
        height, velocity = velocity * sine + height * cosine, velocity * cosine - height * sine
        left = left - time
        on = left > 0
        if not on.any():
            break
        push = np.where(on, 2 * velocity[every, wall] / between[every, wall, wall], 0.0)
        velocity = velocity - push[:, None] * between[every, :, wall]
    return np.asarray(np.maximum(mean + height, 0.0))
