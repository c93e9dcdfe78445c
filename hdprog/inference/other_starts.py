"""Best points of a model other than the drive model, from several starts."""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from hdprog.inference.other_likelihood import OtherLikelihood
from hdprog.inference.starting_points import StartingPoint, descend_all, describe
from hdprog.physics.parameters import FloatArray

_SCREENED, _STARTS = 384, 6
_ITERATIONS, _SCOUTING = 40, 6
_SCALES = 4  # times that the noise scale of nonnegative least squares is found anew
_SAME = 0.1  # of the deviance


def other_starts(
    likelihood: OtherLikelihood, rng: np.random.Generator, known: FloatArray | None = None
) -> list[StartingPoint]:
    """Modes of the posterior, best first; at least one.

    Parameters
    ----------
    likelihood : of the model
    rng : for the draws of the prior
    known : (starts, size) points to start from instead of draws
    """
    if likelihood.model.nonnegative or likelihood.size == 0:
        return [least_squares(likelihood)]
    points = _drawn(likelihood, rng) if known is None else known
    found = descend_all(likelihood, list(points), _ITERATIONS)
    gridded = _from_grid(likelihood, min(found, key=lambda start: start.deviance).point)
    if known is None and gridded.size:
        scouts = descend_all(likelihood, list(gridded), _SCOUTING)
        scouts = sorted(scouts, key=lambda start: start.deviance)[:_STARTS]
        found += descend_all(likelihood, [scout.point for scout in scouts], _ITERATIONS)
    distinct: list[StartingPoint] = []
    for candidate in sorted(found, key=lambda start: start.deviance):
        if all(candidate.deviance - other.deviance > _SAME for other in distinct):
            distinct.append(candidate)
    return distinct


def refit(likelihood: OtherLikelihood, point: FloatArray, iterations: int) -> StartingPoint | None:
    """The mode near a point (size,); None where there is none."""
    if likelihood.model.nonnegative or likelihood.size == 0:
        return least_squares(likelihood)
    found = descend_all(likelihood, [point], iterations)
    return found[0] if found else None


def least_squares(likelihood: OtherLikelihood) -> StartingPoint:
    """Nonnegative least squares with the prior's rows, noise scale and weights in turn.

    Weights at zero have no spread in the Gaussian that is returned.
    """
    size = likelihood.size
    point = np.zeros(size)
    if size == 0:
        return describe(likelihood, point)
    data = likelihood.residual(point[None, :])[0]
    design = likelihood.project(likelihood.design.T).T
    scale = float(np.sqrt(data @ data / likelihood.degrees))
    for _ in range(_SCALES):
        rows = np.vstack([design / scale, np.eye(size)])
        point = nnls(rows, np.concatenate([data / scale, np.zeros(size)]))[0]
        left = data - design @ point
        scale = float(np.sqrt(left @ left / likelihood.degrees))
    curvature = design.T @ design / scale**2 + np.eye(size)
    free = point > 0
    covariance = np.zeros((size, size))
    covariance[np.ix_(free, free)] = np.linalg.inv(curvature[np.ix_(free, free)])
    deviance = likelihood.degrees * np.log(scale**2) + point @ point
    return StartingPoint(point, covariance, float(deviance), scale**2)


def _drawn(likelihood: OtherLikelihood, rng: np.random.Generator) -> FloatArray:
    """The prior's centre and the best few of many draws, (starts, size)."""
    drawn = np.vstack(
        [np.zeros(likelihood.size), rng.standard_normal((_SCREENED, likelihood.size))]
    )
    drawn = drawn[likelihood.supported(drawn)]
    with np.errstate(all="ignore"):
        ranked = np.argsort(-np.nan_to_num(likelihood.log_likelihood(drawn), nan=-np.inf))
    chosen = ranked[np.unique(np.geomspace(1, ranked.size / 4, _STARTS).astype(int) - 1)]
    return np.asarray(np.vstack([drawn[:1], drawn[chosen]]))


def _from_grid(likelihood: OtherLikelihood, best: FloatArray) -> FloatArray:
    """The best point with amplitudes at zero and one parameter on its grid, (points, size)."""
    amplitudes = [one.amplitude for one in likelihood.parameters]
    points = []
    for index, parameter in enumerate(likelihood.parameters):
        if len(parameter.grid) > 1:
            for value in parameter.grid:
                point = np.where(amplitudes, 0.0, best)
                point[index] = value
                points.append(point)
    return np.array(points)
