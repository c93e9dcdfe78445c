"""A limit along paths of a drive's state: how far off it is, and how much it may wander."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hdprog.config import Limit
from hdprog.inference.priors import Prior
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.physics.parameters import FloatArray
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.trend import Paths
from hdprog.trend.wear_coordinates import to_loop

_STEP = 0.02  # of a coordinate, for the slope of a figure
_SLOPE_TIMES = 8


@dataclass(frozen=True)
class Margins:
    """Distance to a limit along paths; zero or less is past it.

    Attributes
    ----------
    margin : (draws, times) in the figure's unit
    wander : (draws, times) variance of the figure added at random since the time before
    """

    margin: FloatArray
    wander: FloatArray


def room(limit: Limit, values: FloatArray) -> FloatArray:
    """How far figures (any shape) are from a limit, in their unit; zero or less is past it."""
    sign = 1.0 if limit.direction == "above" else -1.0
    return sign * (limit.threshold - values)


def margins(
    limit: Limit,
    paths: Paths,
    prior: Prior,
    operation: Operation,
    followed: FollowedEffects | None = None,
) -> Margins:
    """Margins of paths to a limit.

    Parameters
    ----------
    limit : figure, threshold and direction
    paths : of the state
    prior : that the coordinates belong to
    operation : what the figure refers to
    followed : effects that width, loss and lost motion contain
    """
    request = FigureRequest.of(limit)

    def figure(coordinates: FloatArray) -> FloatArray:
        return figure_paths(request, coordinates, prior, operation, followed)

    values = figure(paths.coordinates)
    return Margins(room(limit, values), _wander(figure, values, paths))


def _wander(
    figure: Callable[[FloatArray], FloatArray], values: FloatArray, paths: Paths
) -> FloatArray:
    """Variance of a figure gathered at random between the times, by its slopes.

    The slopes are taken at a few times and interpolated between them.
    """
    times = paths.hours.size
    at = np.unique(np.linspace(0, times - 1, _SLOPE_TIMES).round().astype(np.intp))
    place = np.clip(np.searchsorted(at, np.arange(times), side="right") - 1, 0, at.size - 1)
    after = np.minimum(place + 1, at.size - 1)
    share = (np.arange(times) - at[place]) / np.maximum(at[after] - at[place], 1)

    def slope(direction: FloatArray) -> FloatArray:
        moved = to_loop(paths.states[:, at] + _STEP * direction)
        slopes = (figure(moved) - values[:, at]) / _STEP
        return np.asarray((1 - share) * slopes[:, place] + share * slopes[:, after])

    wander = paths.shared * slope(paths.direction[:, at]) ** 2
    for index, alone in enumerate(np.eye(paths.own.shape[-1])):
        wander = wander + paths.own[..., index] * slope(alone) ** 2
    return np.asarray(wander)
