"""Likelihood of one reduced loop, with angle offset and noise scale integrated out.

The angle of block k is  offset + Δθ_k(parameters, y0) + s·e_k,  e ~ N(0, V) with V known up to the
scale s² (see `noise`). With a flat prior on the offset and 1/s² on s², both are integrated exactly:

    log L = −(n − 1)/2 · log Q + const,   Q = |residual|² in the whitened space without the offset

(Student-t form; e.g. Gelman et al., Bayesian Data Analysis, ch. 14). They are drawn afterwards
from their exact conditional distributions. The slip y0 before the first sample is a parameter:
the fraction q in (0, 1) of the way between the envelopes at the first torque, uniform a priori.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.data.reduce import ReducedLoop
from hdprog.inference.noise import NoiseModel
from hdprog.inference.priors import Prior
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.parameters import NAMES, FloatArray, in_support
from hdprog.physics.torque_path import TorquePath

COUNT = len(NAMES)
_STEP = 1e-4  # of the finite differences, in unconstrained coordinates (of order 1 each)


@dataclass(frozen=True)
class Linearised:
    """Likelihood of a loop in information form: log L(x) ≈ const − ½ xᵀΛx + ηᵀx.

    Attributes
    ----------
    precision : (8, 8) Λ, Gauss-Newton curvature, never negative
    information : (8,) η
    log_likelihood : at the point of linearisation, nuisances at their best, up to a constant
    """

    precision: FloatArray
    information: FloatArray
    log_likelihood: float


@dataclass(frozen=True)
class LoopLikelihood:
    """Likelihood of the parameters, given one reduced loop."""

    reduced: ReducedLoop
    prior: Prior
    alpha: float
    noise: NoiseModel

    def at_path(self, path: TorquePath) -> LoopLikelihood:
        """The same model along another torque path; only `angle` has a meaning there."""
        return replace(self, reduced=replace(self.reduced, path=path))

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return self.reduced.angle.size

    def angle(self, coordinates: FloatArray, fraction: FloatArray) -> FloatArray:
        """Model angle without offset, (draws, blocks) in rad.

        Parameters
        ----------
        coordinates : (draws, 8) unconstrained
        fraction : (draws,) initial slip as a fraction of the way between the envelopes
        """
        parameters = self.prior.to_physical(coordinates)
        return torsion_angle(self.reduced.path, parameters, self.alpha, initial_fraction=fraction)

    def supported(self, coordinates: FloatArray) -> NDArray[np.bool_]:
        """(draws,) whether coordinates (draws, 8) lie in the hard support of the model."""
        return in_support(self.prior.to_physical(coordinates), self.alpha)

    @cached_property
    def _whitened_offset(self) -> FloatArray:
        """(blocks,) unit vector of the offset in the whitened space."""
        ones = self.noise.whiten(np.ones((1, self.blocks)))[0]
        return np.asarray(ones / np.linalg.norm(ones))

    def project(self, angles: FloatArray) -> FloatArray:
        """Whiten angles (draws, blocks) and take the offset's direction out of them."""
        whitened = self.noise.whiten(angles)
        offset = self._whitened_offset
        whitened -= np.outer(whitened @ offset, offset)
        return whitened

    @cached_property
    def _data(self) -> FloatArray:
        return np.asarray(self.project(self.reduced.angle[None, :])[0])

    def residual(self, coordinates: FloatArray, fraction: FloatArray) -> FloatArray:
        """Whitened residual without offset, (draws, blocks)."""
        return np.asarray(self._data - self.project(self.angle(coordinates, fraction)))

    def log_likelihood(self, coordinates: FloatArray, fraction: FloatArray) -> FloatArray:
        """(draws,) log L with offset and noise scale integrated out, up to a constant."""
        residual = self.residual(coordinates, fraction)
        squares = np.einsum("ij,ij->i", residual, residual)
        return np.asarray(-0.5 * (self.blocks - 1) * np.log(squares))

    def nuisances(
        self, coordinates: FloatArray, fraction: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Draw angle offset and noise scale from their exact conditional distributions.

        Returns
        -------
        offset in rad and noise scale s, (draws,) each
        """
        squares = np.einsum("ij,ij->i", *(2 * [self.residual(coordinates, fraction)]))
        scale = np.sqrt(squares / rng.chisquare(self.blocks - 1, squares.size))
        missing = self.reduced.angle - self.angle(coordinates, fraction)
        ones = self.noise.whiten(np.ones((1, self.blocks)))[0]
        precision = ones @ ones
        centre = self.noise.whiten(missing) @ ones / precision
        offset = centre + scale / np.sqrt(precision) * rng.standard_normal(scale.size)
        return offset, scale

    def pointwise(
        self, coordinates: FloatArray, fraction: FloatArray, offset: FloatArray, scale: FloatArray
    ) -> FloatArray:
        """Log density of every block given those before it, (draws, blocks)."""
        missing = self.reduced.angle - self.angle(coordinates, fraction) - offset[:, None]
        whitened = self.noise.whiten(missing) / scale[:, None]
        conditional_sd = scale[:, None] * self.noise.conditional_sd()
        log_density = -0.5 * whitened**2 - np.log(conditional_sd) - 0.5 * np.log(2 * np.pi)
        return np.asarray(log_density)

    def jacobian(self, coordinates: FloatArray, logit: float) -> tuple[FloatArray, FloatArray]:
        """Whitened residual (blocks,) and its derivative (blocks, 9) at one point.

        The columns are the eight coordinates and the logit of the initial slip's fraction.
        """
        point = np.append(coordinates, logit)
        points = np.tile(point, (2 * (COUNT + 1) + 1, 1))
        shift = _STEP * np.eye(COUNT + 1)
        points[1 : COUNT + 2] += shift
        points[COUNT + 2 :] -= shift
        residual = self.residual(points[:, :COUNT], sigmoid(points[:, COUNT]))
        derivative = (residual[1 : COUNT + 2] - residual[COUNT + 2 :]) / (2 * _STEP)
        return residual[0], derivative.T

    def linearise(self, coordinates: FloatArray, variance: float, logit: float) -> Linearised:
        """Gauss-Newton information form of the likelihood at a point; the prior is not in it.

        Parameters
        ----------
        coordinates : (8,) point of linearisation
        variance : s², the noise scale squared, held fixed so that linearisations compare
        logit : initial slip's logit; it is integrated out, with its logistic prior's curvature
        """
        residual, derivative = self.jacobian(coordinates, logit)
        information = derivative.T @ derivative / variance
        gradient = -derivative.T @ residual / variance
        fraction = float(sigmoid(np.array(logit)))
        # Curvature and slope of the logistic prior of the nuisance; then its Schur complement.
        nuisance = information[COUNT, COUNT] + 2 * fraction * (1 - fraction)
        pull = gradient[COUNT] + 1 - 2 * fraction
        cross = information[:COUNT, COUNT]
        precision = information[:COUNT, :COUNT] - np.outer(cross, cross) / nuisance
        slope = gradient[:COUNT] - cross * pull / nuisance
        return Linearised(
            precision=precision,
            information=precision @ coordinates + slope,
            log_likelihood=float(-0.5 * residual @ residual / variance + 0.5 * pull**2 / nuisance),
        )


def sigmoid(value: FloatArray) -> FloatArray:
    """1/(1 + exp(−value)), any shape, without overflow."""
    return np.asarray(np.exp(-np.logaddexp(0.0, -value)))
