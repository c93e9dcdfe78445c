"""Best least-squares points of a loop, from several starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from hdprog.inference.likelihood import COUNT, LoopLikelihood, sigmoid
from hdprog.physics.parameters import FloatArray

_LOGIT_SD = 1.8  # of the logistic distribution
_SCREENED = 384


@dataclass(frozen=True)
class StartingPoint:
    """A mode of the posterior of one loop.

    Attributes
    ----------
    point : (9,) unconstrained coordinates and the initial slip's logit
    covariance : (9, 9) of the Gaussian with the mode's Gauss-Newton curvature
    deviance : −2 log posterior, up to a constant common to all starts
    variance : s², the noise scale squared at the mode
    """

    point: FloatArray
    covariance: FloatArray
    deviance: float
    variance: float


def starting_points(
    likelihood: LoopLikelihood, rng: np.random.Generator, starts: int = 5
) -> list[StartingPoint]:
    """Modes of the posterior, best first, found from the best of many draws of the prior.

    Parameters
    ----------
    likelihood : of the loop
    rng : for the draws of the prior
    starts : least-squares runs; equal results are kept once

    Returns
    -------
    at least one StartingPoint
    """
    prior = likelihood.prior
    drawn = prior.sample(_SCREENED, rng)
    drawn = np.vstack([prior.mean, drawn[likelihood.supported(drawn)]])
    half = np.full(drawn.shape[0], 0.5)
    ranked = np.argsort(-likelihood.log_likelihood(drawn, half))
    # The best few tend to be neighbours: the other starts come from further down the list.
    chosen = ranked[np.unique(np.geomspace(1, ranked.size / 4, starts).astype(int) - 1)]
    found: list[StartingPoint] = []
    for index in chosen:
        candidate = _descend(likelihood, np.append(drawn[index], 0.0))
        if candidate is None:
            continue
        if all(np.abs(candidate.deviance - other.deviance) > 0.1 for other in found):
            found.append(candidate)
    if not found:
        found.append(_describe(likelihood, np.append(prior.mean, 0.0)))
    return sorted(found, key=lambda start: start.deviance)


def _scale(likelihood: LoopLikelihood, point: FloatArray) -> float:
    """Noise scale s² at a point."""
    residual = likelihood.residual(point[None, :COUNT], sigmoid(point[COUNT:]))[0]
    return max(float(residual @ residual) / max(1, likelihood.blocks - 1), 1e-24)


def _descend(likelihood: LoopLikelihood, start: FloatArray) -> StartingPoint | None:
    """Maximum a posteriori near a start: least squares with the noise scale re-estimated."""
    prior = likelihood.prior
    mean, sd = np.append(prior.mean, 0.0), np.append(prior.sd, _LOGIT_SD)
    point = start
    for evaluations in (15, 25):
        scale = np.sqrt(_scale(likelihood, point))

        def residuals(x: FloatArray, scale: float = scale) -> FloatArray:
            fitted = likelihood.residual(x[None, :COUNT], sigmoid(x[COUNT:]))[0] / scale
            fitted = np.where(np.isfinite(fitted), fitted, 1e6)
            return np.concatenate([fitted, (x - mean) / sd])

        def jacobian(x: FloatArray, scale: float = scale) -> FloatArray:
            derivative = likelihood.jacobian(x[:COUNT], float(x[COUNT]))[1] / scale
            return np.vstack([np.nan_to_num(derivative), np.diag(1 / sd)])

        solution = least_squares(
            residuals, point, jac=jacobian, x_scale=sd, max_nfev=evaluations, ftol=1e-6
        )
        point = solution.x
    if not likelihood.supported(point[None, :COUNT])[0]:
        return None
    return _describe(likelihood, point)


def _describe(likelihood: LoopLikelihood, point: FloatArray) -> StartingPoint:
    prior = likelihood.prior
    sd = np.append(prior.sd, _LOGIT_SD)
    variance = _scale(likelihood, point)
    derivative = likelihood.jacobian(point[:COUNT], float(point[COUNT]))[1]
    curvature = np.nan_to_num(derivative.T @ derivative) / variance + np.diag(1 / sd**2)
    logit = point[COUNT]
    log_prior = prior.log_density(point[:COUNT]) + float(-logit - 2 * np.logaddexp(0.0, -logit))
    deviance = (likelihood.blocks - 1) * np.log(variance) - 2 * float(log_prior)
    return StartingPoint(point, np.asarray(np.linalg.inv(curvature)), float(deviance), variance)
