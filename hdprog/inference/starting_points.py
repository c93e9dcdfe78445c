"""Best least-squares points of a loop, from several starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.physics.parameters import FloatArray

_SCREENED = 384


@dataclass(frozen=True)
class StartingPoint:
    """A mode of the posterior of one loop.

    Attributes
    ----------
    point : (size,) as in `likelihood`
    covariance : (size, size) of the Gaussian with the mode's Gauss-Newton curvature
    deviance : −2 log posterior, up to a constant common to all starts
    variance : s², the noise scale squared at the mode
    """

    point: FloatArray
    covariance: FloatArray
    deviance: float
    variance: float


def starting_points(
    likelihood: LoopLikelihood,
    rng: np.random.Generator,
    starts: int = 5,
    known: Sequence[FloatArray] = (),
) -> list[StartingPoint]:
    """Modes of the posterior, best first, found from the best of many draws of the prior.

    Parameters
    ----------
    likelihood : of the loop
    rng : for the draws of the prior
    starts : least-squares runs; equal results are kept once
    known : points (size,) to start from as well; the first gives the effects of the draws

    Returns
    -------
    at least one StartingPoint
    """
    drawn = np.zeros((_SCREENED, likelihood.size))
    drawn[:, :COUNT] = likelihood.prior.sample(_SCREENED, rng)
    if known:
        drawn[:, COUNT + 1 :] = known[0][COUNT + 1 :]
    drawn = np.vstack([likelihood.prior_mean, drawn[likelihood.supported(drawn)]])
    ranked = np.argsort(-likelihood.log_likelihood(drawn))
    # The best few tend to be neighbours: the other starts come from further down the list.
    chosen = ranked[np.unique(np.geomspace(1, ranked.size / 4, starts).astype(int) - 1)]
    found: list[StartingPoint] = []
    for start in [*known, *drawn[chosen]]:
        candidate = descend(likelihood, start)
        if candidate is None:
            continue
        if all(np.abs(candidate.deviance - other.deviance) > 0.1 for other in found):
            found.append(candidate)
    if not found:
        found.append(describe(likelihood, likelihood.prior_mean))
    return sorted(found, key=lambda start: start.deviance)


def _scale(likelihood: LoopLikelihood, point: FloatArray) -> float:
    """Noise scale s² at a point."""
    residual = likelihood.residual(point[None, :])[0]
    return max(float(residual @ residual) / max(1, likelihood.blocks - 1), 1e-24)


def descend(
    likelihood: LoopLikelihood, start: FloatArray, evaluations: tuple[int, ...] = (15, 25)
) -> StartingPoint | None:
    """Maximum a posteriori near a start: least squares with the noise scale re-estimated.

    Parameters
    ----------
    likelihood : of the loop
    start : (size,) point
    evaluations : bounds on the evaluations of the runs, between which the scale is re-estimated

    Returns
    -------
    None where the run left the hard support
    """
    mean, sd = likelihood.prior_mean, likelihood.prior_sd
    point = start
    for most in evaluations:
        scale = np.sqrt(_scale(likelihood, point))

        def residuals(x: FloatArray, scale: float = scale) -> FloatArray:
            fitted = likelihood.residual(x[None, :])[0] / scale
            fitted = np.where(np.isfinite(fitted), fitted, 1e6)
            return np.concatenate([fitted, (x - mean) / sd])

        def jacobian(x: FloatArray, scale: float = scale) -> FloatArray:
            derivative = likelihood.jacobian(x)[1] / scale
            return np.vstack([np.nan_to_num(derivative), np.diag(1 / sd)])

        solution = least_squares(
            residuals, point, jac=jacobian, x_scale=sd, max_nfev=most, ftol=1e-6
        )
        point = solution.x
    if not likelihood.supported(point[None, :])[0]:
        return None
    return describe(likelihood, point)


def describe(likelihood: LoopLikelihood, point: FloatArray) -> StartingPoint:
    """A point (size,) with its Gauss-Newton curvature and deviance."""
    variance = _scale(likelihood, point)
    derivative = likelihood.jacobian(point)[1]
    curvature = np.nan_to_num(derivative.T @ derivative) / variance
    curvature += np.diag(1 / likelihood.prior_sd**2)
    log_prior = float(likelihood.log_prior(point[None, :])[0])
    deviance = (likelihood.blocks - 1) * np.log(variance) - 2 * log_prior
    return StartingPoint(point, np.asarray(np.linalg.inv(curvature)), float(deviance), variance)
