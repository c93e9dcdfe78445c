"""Likelihood of one reduced loop, with angle offset and noise scale integrated out.

A point holds the eight unconstrained coordinates of the drive model, the logit of the initial
slip's fraction and the coordinates of the effects, if there are any: (draws, 9 + effects').

The angle of block k is  offset + Δθ_k(parameters, y0) + s·e_k,  e ~ N(0, V) with V known up to the
scale s² (see `noise`). With a flat prior on the offset and 1/s² on s², both are integrated exactly:

    log L = −(n − 1)/2 · log Q + const,   Q = |residual|² in the whitened space without the offset

(Student-t form; e.g. Gelman et al., Bayesian Data Analysis, ch. 14), n − 1 being fewer where
whitening leaves the blocks correlated (see `effective_blocks`), and both being more where the
readings inside the blocks know the noise, too (see `within_blocks`). They are drawn afterwards
from their exact conditional distributions. The slip y0 before the first sample is a parameter:
the fraction q in (0, 1) of the way between the envelopes at the first torque, uniform a priori.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hdprog.data.reduce import ReducedLoop
from hdprog.inference.noise import NoiseModel
from hdprog.inference.priors import Prior
from hdprog.inference.stepped_angles import stepped_angles
from hdprog.inference.within_blocks import WithinBlocks
from hdprog.physics.course import Course
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.effects.base import Effect, Values
from hdprog.physics.effects.model import EffectSet, EffectsHeld
from hdprog.physics.parameters import NAMES, FloatArray, in_support

COUNT = len(NAMES)
LOGIT_SD = 1.8  # of the logistic distribution
# Of the finite differences, in unconstrained coordinates (of order 1 each). Angles are thousands of
# times their noise: longer steps leave too much curvature, shorter ones too much rounding.
_STEP = 1e-6
_TOGETHER = 96
_LEAST_SCALE = 1e-12
_ROUNDING = 1e-15  # of a sum of squares: what two of them that are alike differ by at least


@dataclass(frozen=True)
class HeldEffects:
    """Effects held at their best values while what they may vary by is integrated out.

    Attributes
    ----------
    coordinates : (k,) best values
    shift : (blocks,) what the prior's centre adds to the angle, to first order, in rad
    features : (blocks, k) what they vary by, over the noise scale, in rad: its coefficients are
        standard Gaussian
    """

    coordinates: FloatArray
    shift: FloatArray
    features: FloatArray


@dataclass(frozen=True)
class LeastSquares:
    """What makes a likelihood that of a fit by least squares, see `least_squares`.

    Attributes
    ----------
    left : (blocks,) what the fit leaves of the angles in rad; parameters are fitted to the others
    weights : noise that weighs angles, in place of the record's own
    squares : sum over the noise's variances that `left` is worth; it tells the noise scale
    """

    left: FloatArray
    weights: NoiseModel
    squares: float


@dataclass(frozen=True)
class LoopLikelihood:
    """Likelihood of the parameters, given one reduced loop.

    Attributes
    ----------
    reduced, prior, alpha, noise : the record, the prior, the gear-tooth angle, the noise
    effects : beside the drive model
    held : values of the effects where they are no part of a point
    effective : degrees of freedom that the blocks are worth, blocks − 1 if None
    within : what the readings inside the blocks say of the noise scale, if it is the blocks'
    least_squares : where the noise would lead the fit away, else None
    """

    reduced: ReducedLoop
    prior: Prior
    alpha: float
    noise: NoiseModel
    effects: tuple[Effect, ...] = ()
    held: HeldEffects | None = None
    effective: float | None = None
    within: WithinBlocks | None = None
    least_squares: LeastSquares | None = None
    # Whether a point begins with the drive model's coordinates, whose ridge is known.
    ridge: ClassVar[bool] = True

    def at_course(self, course: Course) -> LoopLikelihood:
        """The same model along another course; only `angle` has a meaning there."""
        return replace(self, reduced=replace(self.reduced, course=course))

    @cached_property
    def effect_set(self) -> EffectSet:
        """The effects with priors that suit this record."""
        return EffectSet(self.effects, self.reduced.course.scales)

    @cached_property
    def size(self) -> int:
        """Number of coordinates of a point."""
        return COUNT + 1 + (self.effect_set.size if self.held is None else 0)

    @cached_property
    def prior_mean(self) -> FloatArray:
        """(size,) of a point's coordinates; the logit's prior is logistic with that mean."""
        return np.concatenate([self.prior.mean, np.zeros(self.size - COUNT)])

    @cached_property
    def prior_sd(self) -> FloatArray:
        """(size,) of a point's coordinates."""
        effects = np.ones(self.size - COUNT - 1)
        return np.concatenate([self.prior.sd, [LOGIT_SD], effects])

    @cached_property
    def ridge_frame(self) -> tuple[float, float, float]:
        """What the ridge coordinates hang on: tooth angle, scale of T_T, largest torque."""
        largest = self.reduced.path.largest
        return self.alpha, self.prior.softplus_scale, largest

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return self.reduced.angle.size

    @property
    def block_degrees(self) -> float:
        """Degrees of freedom that the blocks give the noise scale."""
        return self.blocks - 1.0 if self.effective is None else self.effective

    @property
    def degrees(self) -> float:
        """Degrees of freedom of the noise scale."""
        return self.block_degrees + (0.0 if self.within is None else self.within.degrees)

    def scale_squared(self, squares: FloatArray) -> FloatArray:
        """Best s², where |residual|² in the whitened space is `squares` (...)."""
        return np.asarray(np.maximum(self._all(squares) / max(1.0, self.degrees), _LEAST_SCALE**2))

    def _all(self, squares: FloatArray) -> FloatArray:
        """The blocks' sums of squares (...) with what else tells the noise scale."""
        known = self.within or self.least_squares
        return squares if known is None else squares + known.squares

    @cached_property
    def fitted(self) -> FloatArray:
        """(blocks,) angles that the parameters are fitted to, in rad."""
        angle, least = self.reduced.angle, self.least_squares
        return angle if least is None else angle - least.left

    @property
    def widening(self) -> float:
        """How many times as wide intervals are as if all blocks were independent."""
        return float(np.sqrt((self.blocks - 1.0) / self.block_degrees))

    def angle(self, points: FloatArray) -> FloatArray:
        """Model angle without offset, (draws, blocks) in rad, at points (draws, size)."""
        if self.effects and self.held is None:
            return self.angle_with(points, self.effect_values(points))
        parameters, path = self.prior.to_physical(points[:, :COUNT]), self.reduced.course.path
        fraction = sigmoid(points[:, COUNT])
        if self.held is None:
            return torsion_angle(path, parameters, self.alpha, initial_fraction=fraction)
        return self._held.angle(parameters, self.alpha, fraction) + self.held.shift

    def effect_values(self, points: FloatArray) -> dict[str, Values]:
        """Values of the effects by id and name, (draws, 1) each, at points (draws, size)."""
        return self.effect_set.values(points[:, COUNT + 1 :])

    def angle_with(
        self, points: FloatArray, values: dict[str, Values], effects: EffectSet | None = None
    ) -> FloatArray:
        """The angle where effects have other values than points (draws, size) have.

        Of some of the effects only, where these are given.
        """
        parameters = self.prior.to_physical(points[:, :COUNT])
        fraction, course = sigmoid(points[:, COUNT]), self.reduced.course
        effects = self.effect_set if effects is None else effects
        return effects.angle(course, parameters, values, self.alpha, fraction)

    @cached_property
    def _held(self) -> EffectsHeld:
        assert self.held is not None
        values = self.effect_set.values(self.held.coordinates[None, :])
        return self.effect_set.held(self.reduced.course, values)

    def supported(self, points: FloatArray) -> NDArray[np.bool_]:
        """(draws,) whether points (draws, size) lie in the hard support of the model."""
        parameters = self.prior.to_physical(points[:, :COUNT])
        inside = in_support(parameters, self.alpha)
        sides = [effect for effect in self.effects if effect.acts_on == "parameters"]
        if sides:
            effects = points[:, COUNT + 1 :] if self.held is None else self.held.coordinates[None]
            values = self.effect_set.values(effects)
            for effect in sides:
                negative = effect.negative_side(parameters, values[effect.id])
                inside &= in_support(negative, self.alpha)
        return inside

    def log_prior(self, points: FloatArray) -> FloatArray:
        """(draws,) log prior density of points (draws, size), up to a constant."""
        logit, effects = points[:, COUNT], points[:, COUNT + 1 :]
        density = self.prior.log_density(points[:, :COUNT])
        density = density - logit - 2 * np.logaddexp(0.0, -logit)
        return np.asarray(density - 0.5 * np.einsum("ij,ij->i", effects, effects))

    def whiten(self, angles: FloatArray) -> FloatArray:
        """Angles (draws, blocks) in rad → independent with variance s², held effects included."""
        white = self._weights.whiten(angles)
        if self.held is not None:
            directions, share = self._held_directions
            white -= (white @ directions * share) @ directions.T
        return white

    @property
    def _weights(self) -> NoiseModel:
        return self.noise if self.least_squares is None else self.least_squares.weights

    @cached_property
    def _held_directions(self) -> tuple[FloatArray, FloatArray]:
        """(blocks, k) where held effects add noise to white noise, and by what to shorten it there.

        I + G Gᵀ = U (1 + S²) Uᵀ in the space of G = U S Vᵀ, and its inverse square root whitens.
        """
        assert self.held is not None
        features = self._weights.whiten(self.held.features.T).T
        directions, strength, _ = np.linalg.svd(features, full_matrices=False)
        return directions, 1 - 1 / np.hypot(1, strength)

    @cached_property
    def _whitened_offset(self) -> FloatArray:
        """(blocks,) unit vector of the offset in the whitened space."""
        ones = self.whiten(np.ones((1, self.blocks)))[0]
        return np.asarray(ones / np.linalg.norm(ones))

    def project(self, angles: FloatArray) -> FloatArray:
        """Whiten angles (draws, blocks) and take the offset's direction out of them."""
        whitened = self.whiten(angles)
        offset = self._whitened_offset
        whitened -= np.outer(whitened @ offset, offset)
        return whitened

    @cached_property
    def _data(self) -> FloatArray:
        return np.asarray(self.project(self.fitted[None, :])[0])

    def residual(self, points: FloatArray) -> FloatArray:
        """Whitened residual without offset, (draws, blocks)."""
        return np.asarray(self._data - self.project(self.angle(points)))

    def log_likelihood(self, points: FloatArray) -> FloatArray:
        """(draws,) log L with offset and noise scale integrated out, up to a constant."""
        return self.log_likelihood_of(self.angle(points))

    def log_likelihood_of(self, angles: FloatArray) -> FloatArray:
        """The same of model angles (draws, blocks) in rad."""
        left = self.whiten(angles)
        np.subtract(self._data, left, out=left)
        whole = np.einsum("ij,ij->i", left, left)
        squares = np.maximum(whole - (left @ self._whitened_offset) ** 2, _ROUNDING * whole)
        return np.asarray(-0.5 * self.degrees * np.log(self._all(squares)))

    def offset(self, missing: FloatArray) -> float:
        """Best angle offset in rad, given what the model leaves (blocks,)."""
        whitened = self.whiten(np.stack([missing, np.ones_like(missing)]))
        return float(whitened[0] @ whitened[1] / (whitened[1] @ whitened[1]))

    def nuisances(
        self, points: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Draw angle offset and noise scale from their exact conditional distributions.

        Where blocks count for fewer, the scale is `widening` times that of the noise itself.

        Returns
        -------
        offset in rad and noise scale s, (draws,) each
        """
        squares, along = np.empty(len(points)), np.empty(len(points))
        # Few points at a time: their angles stay in the processor's cache.
        for start in range(0, len(points), _TOGETHER):
            part = slice(start, start + _TOGETHER)
            left = self.whiten(self.fitted - self.angle(points[part]))
            along[part] = left @ self._whitened_offset
            left -= np.outer(along[part], self._whitened_offset)
            squares[part] = np.einsum("ij,ij->i", left, left)
        scale = np.sqrt(self._all(squares) / rng.chisquare(self.degrees, squares.size))
        length = np.linalg.norm(self.whiten(np.ones((1, self.blocks))))
        offset = (along + scale * rng.standard_normal(scale.size)) / length
        return offset, scale

    def pointwise(self, points: FloatArray, offset: FloatArray, scale: FloatArray) -> FloatArray:
        """Log density of every block given those before it, (draws, blocks).

        Raises ValueError where effects are held: the blocks are then no chain.
        """
        if self.held is not None:
            raise ValueError("blocks have no density of their own where effects are integrated out")
        missing = self.reduced.angle - self.angle(points) - offset[:, None]
        whitened = self.noise.whiten(missing) / scale[:, None]
        conditional_sd = scale[:, None] * self.noise.conditional_sd()
        log_density = -0.5 * whitened**2 - np.log(conditional_sd) - 0.5 * np.log(2 * np.pi)
        return np.asarray(log_density)

    def jacobian(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Whitened residual (blocks,) and its derivative (blocks, size) at one point (size,).

        Central differences: at a kink (a reversal, the teeth's threshold) both sides count.
        """
        residual = self._residuals_about(point[None], _STEP, -_STEP)[0]
        derivative = (residual[1 : self.size + 1] - residual[self.size + 1 :]) / (2 * _STEP)
        return residual[0], derivative.T

    def jacobians(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The same at points (points, size) by forward differences, at half the cost of each.

        Returns
        -------
        (points, blocks) and (points, blocks, size)
        """
        residual = self._residuals_about(points, _STEP)
        derivative = (residual[:, 1:] - residual[:, :1]) / _STEP
        return residual[:, 0], derivative.transpose(0, 2, 1)

    def _residuals_about(self, points: FloatArray, *steps: float) -> FloatArray:
        """`residual` where `stepped_angles` leads from points (points, size)."""
        angles = stepped_angles(self, points, steps)
        projected = self.project(angles.reshape(-1, self.blocks))
        return np.asarray(self._data - projected.reshape(angles.shape))


def sigmoid(value: FloatArray) -> FloatArray:
    """1/(1 + exp(−value)), any shape, without overflow."""
    return np.asarray(np.exp(-np.logaddexp(0.0, -value)))
