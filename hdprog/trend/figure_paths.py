"""Figures of merit along paths of a drive's state."""

from __future__ import annotations

import math

import numpy as np

from hdprog.inference.priors import Prior
from hdprog.physics.figures import FigureRequest, Operation, figure
from hdprog.physics.parameters import NAMES, FloatArray, Parameters
from hdprog.physics.steady_cycle import QUANTITIES, whole_figure
from hdprog.trend.followed_effects import FollowedEffects

_COUNT = len(NAMES)
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
    request: FigureRequest,
    coordinates: FloatArray,
    prior: Prior,
    operation: Operation,
    followed: FollowedEffects | None = None,
) -> FloatArray:
    """One figure of merit along paths.

    Parameters
    ----------
    request : which figure
    coordinates : (..., n) unconstrained, then amplitudes of the effects that are followed
    prior : that the coordinates belong to
    operation : what the figure refers to
    followed : effects that width, loss and lost motion contain; none if None

    Returns
    -------
    (...) in the figure's own unit
    """
    flat = coordinates.reshape(-1, coordinates.shape[-1])
    whole = followed is not None and request.quantity in QUANTITIES

    def batch(some: FloatArray) -> FloatArray:
        parameters = supported(prior, some[:, :_COUNT], operation.alpha)
        if followed is None or not whole:
            return figure(request, parameters, operation)
        lasting = followed.lasting(some[:, _COUNT:])
        return whole_figure(request.quantity, parameters, operation, lasting)

    size = _BATCH // 10 if whole else _BATCH
    values = [batch(flat[start : start + size]) for start in range(0, len(flat), size)]
    return np.concatenate(values).reshape(coordinates.shape[:-1])
