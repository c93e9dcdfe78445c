"""The way back from what a loop's prior and its noise are made of, for tests that begin there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hdprog.inference.noise import NoiseModel
from hdprog.inference.priors import Prior
from hdprog.physics.parameters import BY_NAME, NAMES, FloatArray


def coordinates_of(prior: Prior, parameters: Mapping[str, float | FloatArray]) -> FloatArray:
    """Unconstrained coordinates (..., 8) of physical parameters by name, (...) each."""
    columns = [
        BY_NAME[name].to_coordinate(np.asarray(parameters[name]), prior.softplus_scale)
        for name in NAMES
    ]
    return np.stack(columns, axis=-1)


def decaying(sd: FloatArray, log_ratio: float, length: float, position: FloatArray) -> NoiseModel:
    """White noise sd (blocks,) plus an Ornstein-Uhlenbeck term over positions (blocks,)."""
    distance = np.abs(position[:, None] - position[None, :])
    variance = float(np.mean(sd**2) * np.exp(log_ratio))
    correlated = variance * np.exp(-distance / length)
    return NoiseModel.white(sd).with_decaying(correlated, variance, length, position)
