"""Noise of the blocks of a loop: white, or white with Ornstein-Uhlenbeck terms.

The shape of the covariance comes from `noise_shape`; its scale stays a parameter of the posterior.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from hdprog.inference.smooth_term import SmoothTerm
from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

WHITE = "white noise, independent from block to block"
_BLIND = 1e4  # times its noise: a block that a fit does not see
_FORGOTTEN = 1e-10  # of a whitened block's largest weight: what lies further back is left out
_TOGETHER = 64  # whitened blocks that share one multiplication


@dataclass(frozen=True)
class NoiseModel:
    """Covariance of the blocks' angles up to a common factor s².

    Attributes
    ----------
    sd : (blocks,) standard deviation of each block's angle for s = 1, in rad
    white_sd : (blocks,) its part that is independent from block to block
    whitening : (blocks, blocks) matrix that makes rows of angles white, or None if they are
    words : the model in words, for the report
    log_ratio, correlation_length : of the likeliest Ornstein-Uhlenbeck term, log of its variance
        over the mean white one and its decay in the unit of the positions; None without one
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
        return NoiseModel(sd, sd, None, WHITE)

    @staticmethod
    def with_covariance(covariance: FloatArray, words: str) -> NoiseModel:
        """Of blocks with a covariance (blocks, blocks) for s = 1, in rad²."""
        sd = np.sqrt(np.diag(covariance))
        return NoiseModel(sd, sd, _whitening(covariance), words)

    def with_decaying(
        self, correlated: FloatArray, variance: float, length: float, position: FloatArray
    ) -> NoiseModel:
        """White noise plus a correlated covariance (blocks, blocks) in rad².

        The likeliest term's variance in rad² and length give its words.
        """
        log_ratio = float(np.log(variance / np.mean(self.white_sd**2)))
        share = 1 / (1 + np.exp(-log_ratio))
        words = (
            "white noise plus Ornstein-Uhlenbeck terms, the likeliest of which carries "
            f"{share:.0%} of a typical block's variance and decays over "
            f"{length / np.ptp(position):.1%} of the record"
        )
        covariance = np.diag(self.white_sd**2) + correlated
        return replace(
            NoiseModel.with_covariance(covariance, words),
            white_sd=self.white_sd,
            log_ratio=log_ratio,
            correlation_length=length,
        )

    def with_term(self, term: SmoothTerm, course: Course) -> NoiseModel:
        """The same noise plus an empirical smooth term, its coefficients integrated out."""
        features = term.features(course)
        covariance = self.covariance + features @ features.T
        return replace(
            self,
            sd=np.sqrt(np.diag(covariance)),
            whitening=_whitening(covariance),
            words=f"{self.words}, beside an empirical term over {term.coordinate}",
            term=term,
            features=features,
        )

    @cached_property
    def covariance(self) -> FloatArray:
        """(blocks, blocks) for s = 1, in rad²."""
        if self.whitening is None:
            return np.diag(self.sd**2)
        colouring = np.linalg.inv(self.whitening)
        return np.asarray(colouring.T @ colouring)

    @property
    def scatter(self) -> FloatArray:
        """(blocks,) sd of each block for s = 1 about the angle with the empirical term, in rad."""
        return np.asarray(np.sqrt(self.sd**2 - np.sum(self.block_features**2, axis=1)))

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
        if self.whitening is None:
            return angles / self.sd
        white = np.empty_like(angles)
        for seen, columns, part in self._pieces:
            np.matmul(angles[:, seen], part, out=white[:, columns])
        return white

    @cached_property
    def _pieces(self) -> list[tuple[slice, slice, FloatArray]]:
        """The whitening by columns, without the blocks that come later or are long forgotten."""
        assert self.whitening is not None
        pieces = []
        for start in range(0, self.sd.size, _TOGETHER):
            columns = slice(start, min(start + _TOGETHER, self.sd.size))
            part = np.abs(self.whitening[:, columns])
            first = int(np.argmax((part > _FORGOTTEN * part.max(axis=0)).any(axis=1)))
            seen = slice(first, columns.stop)
            pieces.append((seen, columns, np.ascontiguousarray(self.whitening[seen, columns])))
        return pieces

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
