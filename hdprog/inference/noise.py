"""Noise of the blocks of a loop: white, or white with an Ornstein-Uhlenbeck term.

The shape of the covariance is found from the residual of the best fit by restricted likelihood
(the fitted sensitivities projected out); its scale stays a parameter of the posterior.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded, solve_triangular
from scipy.optimize import minimize
from scipy.stats import chi2

from hdprog.inference.smooth_term import SmoothTerm
from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

_BLIND = 1e4  # times its noise: a block that a fit does not see

FALSE_ALARM_RATE = 0.01
"""Share of loops with white noise that get the correlated model all the same (tested)."""


@dataclass(frozen=True)
class NoiseModel:
    """Covariance of the blocks' angles up to a common factor s².

    Attributes
    ----------
    sd : (blocks,) standard deviation of each block's angle for s = 1, in rad
    white_sd : (blocks,) its part that is independent from block to block
    whitening : (blocks, blocks) matrix that makes rows of angles white, or None if they are
    words : the model in words, for the report
    log_ratio, correlation_length : of the Ornstein-Uhlenbeck term, log of its variance over the
        mean white one and its decay in the unit of the positions; None without one
    term, features : an empirical smooth term and its (blocks, k) features, or None
    """

    sd: FloatArray
    white_sd: FloatArray
    whitening: FloatArray | None
    words: str
    log_ratio: float | None = None
    correlation_length: float | None = None
    term: SmoothTerm | None = None
    features: FloatArray | None = None

    @staticmethod
    def white(sd: FloatArray) -> NoiseModel:
        """Independent blocks with relative standard deviations sd (blocks,) in rad."""
        return NoiseModel(sd, sd, None, "white noise, independent from block to block")

    @staticmethod
    def decaying(
        sd: FloatArray, log_ratio: float, length: float, position: FloatArray
    ) -> NoiseModel:
        """White noise sd (blocks,) plus an Ornstein-Uhlenbeck term over positions (blocks,)."""
        distance = np.abs(position[:, None] - position[None, :])
        correlated = np.mean(sd**2) * np.exp(log_ratio - distance / length)
        share = 1 / (1 + np.exp(-log_ratio))
        words = (
            f"white noise plus an Ornstein-Uhlenbeck term that carries {share:.0%} of a typical "
            f"block's variance and decays over {length / np.ptp(position):.1%} of the record"
        )
        covariance = np.diag(sd**2) + correlated
        return NoiseModel(
            np.sqrt(np.diag(covariance)), sd, _whitening(covariance), words, log_ratio, length
        )

    def with_term(self, term: SmoothTerm, course: Course) -> NoiseModel:
        """The same noise plus an empirical smooth term, its coefficients integrated out."""
        features = term.features(course)
        return replace(
            self.with_features(features),
            words=f"{self.words}, beside an empirical term over {term.coordinate}",
            term=term,
            features=features,
        )

    def with_features(self, features: FloatArray) -> NoiseModel:
        """The same noise plus columns (blocks, k) with standard Gaussian coefficients."""
        covariance = self.covariance + features @ features.T
        return replace(self, sd=np.sqrt(np.diag(covariance)), whitening=_whitening(covariance))

    @property
    def covariance(self) -> FloatArray:
        """(blocks, blocks) for s = 1, in rad²."""
        if self.whitening is None:
            return np.diag(self.sd**2)
        colouring = np.linalg.inv(self.whitening)
        return np.asarray(colouring.T @ colouring)

    @property
    def as_white(self) -> NoiseModel:
        """The part that is independent from block to block."""
        return NoiseModel.white(self.white_sd)

    def masking(self, out: NDArray[np.bool_]) -> NoiseModel:
        """The same noise with some blocks (blocks,) as good as not measured."""
        blind = np.where(out, _BLIND, 1.0)
        if self.whitening is None:
            sd = self.sd * blind
            return replace(self, sd=sd, white_sd=sd)
        added = np.where(out, (_BLIND * self.white_sd) ** 2, 0.0)
        covariance = self.covariance + np.diag(added)
        return replace(self, sd=np.sqrt(np.diag(covariance)), whitening=_whitening(covariance))

    @property
    def block_features(self) -> FloatArray:
        """(blocks, k) features of the empirical term; (blocks, 0) without one."""
        return np.zeros((self.sd.size, 0)) if self.features is None else self.features

    def coefficients(self, residual: FloatArray) -> FloatArray:
        """Best coefficients (..., k) of the empirical term, given what is left (..., blocks)."""
        assert self.features is not None
        assert self.whitening is not None
        return np.asarray(residual @ self.whitening @ self.whitening.T @ self.features)

    def smooth_part(self, residual: FloatArray) -> FloatArray:
        """The empirical term's share of a residual (..., blocks) in rad; zero without one."""
        if self.features is None:
            return np.zeros_like(residual)
        return np.asarray(self.coefficients(residual) @ self.features.T)

    def whiten(self, angles: FloatArray) -> FloatArray:
        """Angles (draws, blocks) in rad → independent with variance s²."""
        return angles / self.sd if self.whitening is None else angles @ self.whitening

    @cached_property
    def log_det(self) -> float:
        """Log determinant of the covariance for s = 1."""
        return float(2 * np.log(self.conditional_sd()).sum())

    def conditional_sd(self) -> FloatArray:
        """(blocks,) standard deviation of each block given those before it, for s = 1, in rad."""
        return self.sd if self.whitening is None else np.asarray(1 / np.diag(self.whitening))


def _whitening(covariance: FloatArray) -> FloatArray:
    factor = np.linalg.cholesky(covariance)
    inverse = solve_triangular(factor, np.eye(factor.shape[0]), lower=True)
    return np.ascontiguousarray(inverse.T)


@dataclass(frozen=True)
class DecayingNoise:
    """White noise plus an Ornstein-Uhlenbeck term, solved in a time linear in the blocks.

    The inverse of the term's covariance K is tridiagonal, so with M = K⁻¹ + D⁻¹
    (D + K)⁻¹ = D⁻¹ − D⁻¹M⁻¹D⁻¹ and |D + K| = |M||K||D|.
    """

    variance: FloatArray
    factor: FloatArray
    log_det: float

    @staticmethod
    def of(variance: FloatArray, correlated: float, steps: FloatArray) -> DecayingNoise:
        """From white variances (blocks,), the term's variance and steps (blocks − 1,) in lengths.

        Raises LinAlgError where the numbers are too far apart to be solved.
        """
        kept = np.exp(-steps)
        renewed = -np.expm1(-2 * steps) * correlated
        banded = np.zeros((2, variance.size))
        banded[1] = 1 / variance
        banded[1, 0] += 1 / correlated
        banded[1, 1:] += 1 / renewed
        banded[1, :-1] += kept**2 / renewed
        banded[0, 1:] = -kept / renewed
        factor = cholesky_banded(banded)
        log_det = 2 * np.log(factor[1]).sum() + np.log(renewed).sum() + np.log(correlated)
        return DecayingNoise(variance, factor, float(log_det + np.log(variance).sum()))

    def solve(self, columns: FloatArray) -> FloatArray:
        """(D + K)⁻¹ times columns (blocks, k)."""
        scaled = columns / self.variance[:, None]
        inner = cho_solve_banded((self.factor, False), scaled)
        return np.asarray(scaled - inner / self.variance[:, None])


def _restricted_deviance(
    solved: FloatArray, log_det: float, residual: FloatArray, sensitivities: FloatArray
) -> float:
    """−2 log restricted likelihood, the scale profiled out, up to a constant.

    `solved` is the inverse covariance times residual and sensitivities, (blocks, 1 + k).
    """
    weighted, projected = solved[:, 0], sensitivities.T @ solved[:, 1:]
    cross = sensitivities.T @ weighted
    quadratic = residual @ weighted - cross @ np.linalg.solve(projected, cross)
    degrees = residual.size - sensitivities.shape[1]
    return float(degrees * np.log(quadratic) + log_det + np.linalg.slogdet(projected)[1])


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
    steps = np.maximum(np.diff(position), 1e-9 * (position[-1] - position[0]))
    typical, extent = float(np.median(steps)), float(position[-1] - position[0])
    mean_variance = float(np.mean(sd**2))
    columns = np.column_stack([residual, basis])

    def deviance(theta: FloatArray) -> float:
        try:
            noise = DecayingNoise.of(
                sd**2, mean_variance * np.exp(theta[0]), steps / np.exp(theta[1])
            )
        except np.linalg.LinAlgError:
            return np.inf
        return _restricted_deviance(noise.solve(columns), noise.log_det, residual, basis)

    white = _restricted_deviance(
        columns / sd[:, None] ** 2, float(2 * np.log(sd).sum()), residual, basis
    )
    bounds = [(np.log(1e-3), np.log(1e4)), (np.log(typical), np.log(extent))]
    starts = [(0.0, np.log(3 * typical)), (1.0, np.log(0.1 * extent))]
    best = min(starts, key=lambda start: deviance(np.array(start)))
    found = minimize(
        deviance, best, method="L-BFGS-B", bounds=bounds, options={"maxiter": 15, "eps": 1e-3}
    )
    if white - found.fun < chi2.isf(FALSE_ALARM_RATE, 2):
        return NoiseModel.white(sd)
    return NoiseModel.decaying(sd, float(found.x[0]), float(np.exp(found.x[1])), position)
