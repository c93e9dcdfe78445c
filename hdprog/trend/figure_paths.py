"""Figures of merit along paths of a drive's state."""

from __future__ import annotations

import math

import numpy as np

from hdprog.inference.priors import Prior
from hdprog.physics.figures import FigureRequest, Operation, figure
from hdprog.physics.parameters import FloatArray, Parameters

_BATCH = 20_000
_INSIDE = 0.95  # share of the hard support that a forecast may use


def supported(prior: Prior, coordinates: FloatArray, alpha: float) -> Parameters:
    """Parameters (draws,) of coordinates (draws, 8), friction held inside the model's support.

    Far forecasts may carry friction to where the teeth would lock themselves (see
    `hdprog.physics.parameters.in_support`); it stays just short of that.
    """
    values = dict(prior.to_physical(coordinates))
    bound = _INSIDE * min(math.tan(alpha), 1 / math.tan(alpha))
    values["mu"] = np.minimum(values["mu"], bound)
    steepest = _INSIDE * math.sin(alpha) / values["mu"] + math.cos(alpha)
    values["c"] = np.maximum(values["c"], -steepest)
    return values


def figure_paths(
    request: FigureRequest, coordinates: FloatArray, prior: Prior, operation: Operation
) -> FloatArray:
    """One figure of merit along paths.

    Parameters
    ----------
    request : which figure
    coordinates : (..., 8) unconstrained
    prior : that the coordinates belong to
    operation : what the figure refers to

    Returns
    -------
    (...) in the figure's own unit
    """
    flat = coordinates.reshape(-1, coordinates.shape[-1])
    values = [
        figure(request, supported(prior, flat[start : start + _BATCH], operation.alpha), operation)
        for start in range(0, len(flat), _BATCH)
    ]
    return np.concatenate(values).reshape(coordinates.shape[:-1])
