"""Noise of the blocks of a loop: white, or white with an Ornstein-Uhlenbeck term.

The shape of the covariance is found from the residual of the best fit by restricted likelihood
(the fitted sensitivities projected out); its scale stays a parameter of the posterior.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize
from scipy.stats import chi2

from hdprog.physics.parameters import FloatArray

FALSE_ALARM_RATE = 0.01
"""Share of loops with white noise that get the correlated model all the same (tested)."""


@dataclass(frozen=True)
class NoiseModel:
    """Covariance of the blocks' angles up to a common factor s².

    Attributes
    ----------
    sd : (blocks,) standard deviation of each block's angle for s = 1, in rad
    whitening : (blocks, blocks) matrix that makes rows of angles white, or None if they are
    words : the model in words, for the report
    correlation_length : of the Ornstein-Uhlenbeck term, in the unit of the positions, or None
    """

    sd: FloatArray
    whitening: FloatArray | None
    words: str
    correlation_length: float | None = None

    @staticmethod
    def white(sd: FloatArray) -> NoiseModel:
        """Independent blocks with relative standard deviations sd (blocks,) in rad."""
        return NoiseModel(sd, None, "white noise, independent from block to block")

    @staticmethod
    def correlated(covariance: FloatArray, words: str, correlation_length: float) -> NoiseModel:
        """Blocks with a given covariance (blocks, blocks) in rad², up to its scale."""
        factor = np.linalg.cholesky(covariance)
        inverse = solve_triangular(factor, np.eye(factor.shape[0]), lower=True)
        whitening = np.ascontiguousarray(inverse.T)
        return NoiseModel(np.sqrt(np.diag(covariance)), whitening, words, correlation_length)

    def whiten(self, angles: FloatArray) -> FloatArray:
        """Angles (draws, blocks) in rad → independent with variance s²."""
        return angles / self.sd if self.whitening is None else angles @ self.whitening

    def conditional_sd(self) -> FloatArray:
        """(blocks,) standard deviation of each block given those before it, for s = 1, in rad."""
        return self.sd if self.whitening is None else np.asarray(1 / np.diag(self.whitening))


def _restricted_deviance(
    covariance: FloatArray, residual: FloatArray, sensitivities: FloatArray
) -> float:
    """−2 log restricted likelihood, the scale profiled out, up to a constant."""
    try:
        factor = cho_factor(covariance, lower=True)
    except np.linalg.LinAlgError:
        return np.inf
    solved = cho_solve(factor, np.column_stack([residual, sensitivities]))
    weighted, projected = solved[:, 0], sensitivities.T @ solved[:, 1:]
    cross = sensitivities.T @ weighted
    quadratic = residual @ weighted - cross @ np.linalg.solve(projected, cross)
    degrees = residual.size - sensitivities.shape[1]
    log_det = 2 * np.log(np.diag(factor[0])).sum() + np.linalg.slogdet(projected)[1]
    return float(degrees * np.log(quadratic) + log_det)


def fit_noise(
    residual: FloatArray, sensitivities: FloatArray, sd: FloatArray, position: FloatArray
) -> NoiseModel:
    """Test whether a residual is white and, where it is not, fit the correlated model.

    Parameters
    ----------
    residual : (blocks,) angle minus best fit in rad
    sensitivities : (blocks, k) derivatives of the fit that absorbed part of the residual
    sd : (blocks,) relative standard deviation of the white part in rad
    position : (blocks,) increasing time or index that correlation decays over

    Returns
    -------
    NoiseModel, white where the likelihood-ratio test keeps white at `FALSE_ALARM_RATE`
    """
    # Directions that the data do not see make no projection.
    left, strength, _ = np.linalg.svd(sensitivities / sd[:, None], full_matrices=False)
    basis = left[:, strength > 1e-8 * strength[0]] * sd[:, None]
    distance = np.abs(position[:, None] - position[None, :])
    typical = float(np.median(np.diff(position)))
    extent = float(position[-1] - position[0])
    mean_variance = float(np.mean(sd**2))

    def covariance(log_ratio: float, log_length: float) -> FloatArray:
        correlated = mean_variance * np.exp(log_ratio - distance / np.exp(log_length))
        return np.asarray(np.diag(sd**2) + correlated)

    def deviance(theta: FloatArray) -> float:
        return _restricted_deviance(covariance(theta[0], theta[1]), residual, basis)

    white = _restricted_deviance(np.diag(sd**2), residual, basis)
    bounds = [(np.log(1e-3), np.log(1e4)), (np.log(typical), np.log(extent))]
    starts = [(0.0, np.log(3 * typical)), (1.0, np.log(0.1 * extent))]
    best = min(starts, key=lambda start: deviance(np.array(start)))
    found = minimize(
        deviance, best, method="L-BFGS-B", bounds=bounds, options={"maxiter": 15, "eps": 1e-3}
    )
    if white - found.fun < chi2.isf(FALSE_ALARM_RATE, 2):
        return NoiseModel.white(sd)
    full = covariance(found.x[0], found.x[1])
    share = float(1 / (1 + np.exp(-found.x[0])))
    length = float(np.exp(found.x[1]))
    words = (
        f"white noise plus an Ornstein-Uhlenbeck term that carries {share:.0%} of a typical "
        f"block's variance and decays over {length / extent:.1%} of the record"
    )
    return NoiseModel.correlated(full, words, length)
