"""Least squares where correlated noise leads a fit away from the readings.

Under an Ornstein-Uhlenbeck or an empirical term a fit weighs slow deviations lightly. Where the
term is an error of the record that is right, and the fit lies near that of least squares. Where it
stands for what the model lacks, the fit may run far from the readings, and differently in records
that are alike. Whether it lies outside the region in which such errors leave least squares is a
test of specification, after Hausman (Econometrica 46 (1978) 1251). Where it does, least squares are
kept, with the spread that the errors give these: along what the data see the likelihood is that of
the projected errors (the sandwich of White, Econometrica 50 (1982) 1), and what the fit leaves is
taken out of the angles, so that nothing is gained by bending towards it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from hdprog.inference.effective_blocks import fixed_directions
from hdprog.inference.likelihood import LeastSquares, LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.starting_points import StartingPoint, descend_all
from hdprog.physics.parameters import FloatArray

LED_AWAY_RATE = 0.01
"""Bound on the share of records whose noise is as its model says that are taken for led away:
under the right noise a fit lies nearer to least squares than these lie to the truth."""

_SEEN = 1e-8  # of the strongest direction: what the data see at all


@dataclass(frozen=True)
class _Spread:
    """How errors with a covariance spread a fit by least squares.

    Attributes
    ----------
    fixed : (blocks, f) orthonormal whitened directions along which the data fix the fit
    along : (f, f) covariance of the errors along them, for s = 1
    variance : s², from what the fit leaves
    """

    fixed: FloatArray
    along: FloatArray
    variance: float

    @staticmethod
    def of(white: LoopLikelihood, start: StartingPoint, covariance: FloatArray) -> _Spread:
        """About the mode of a likelihood with white noise, of errors (blocks, blocks) in rad²."""
        residual, derivative = white.jacobian(start.point)
        sd = white.noise.white_sd
        offset = (1 / sd) / np.linalg.norm(1 / sd)
        columns = np.column_stack([np.nan_to_num(derivative) * white.prior_sd, offset])
        left, strength, _ = np.linalg.svd(columns, full_matrices=False)
        basis = left[:, strength > _SEEN * strength[0]]
        whitened = covariance / np.outer(sd, sd)
        # What the data see the fit took of the errors: the others show how large they are.
        squares = float(residual @ residual)
        variance = squares / float(np.trace(whitened) - np.sum(basis * (whitened @ basis)))
        scale = np.sqrt(squares / residual.size)
        fixed = fixed_directions(derivative / scale, white.prior_sd)
        return _Spread(fixed, fixed.T @ whitened @ fixed, variance)

    def holds(self, difference: FloatArray) -> bool:
        """Whether a whitened difference (blocks,) of angles is one that the errors would make."""
        moved = self.fixed.T @ difference
        distance = moved @ np.linalg.solve(self.variance * self.along, moved)
        return bool(distance <= chdtri(moved.size, LED_AWAY_RATE))

    def weights(self, sd: FloatArray) -> NoiseModel:
        """Noise that gives least squares their spread; the white one's deviations sd (blocks,)."""
        # Beside these, where a fit that goes far bends to, errors count as in their mean.
        beside = float(np.exp(np.linalg.slogdet(self.along)[1] / len(self.along)))
        more = self.fixed @ (self.along - beside * np.eye(len(self.along))) @ self.fixed.T
        covariance = (beside * np.eye(len(sd)) + more) * np.outer(sd, sd)
        return NoiseModel.with_covariance(covariance, "weights of least squares")


def kept_to_readings(
    likelihood: LoopLikelihood, starts: list[StartingPoint], known: Sequence[FloatArray] = ()
) -> tuple[LoopLikelihood, list[StartingPoint]]:
    """The likelihood, or that of least squares where its noise leads the fit away from them.

    Parameters
    ----------
    likelihood : with its noise
    starts : its modes, best first
    known : points (size,) to seek the best least squares from as well

    Returns
    -------
    the likelihood to be sampled, and its modes, best first
    """
    noise = likelihood.noise
    if noise.whitening is None:
        return likelihood, starts
    white = replace(likelihood, noise=noise.as_white)
    found = descend_all(white, [*(start.point for start in starts), *known])
    if not found:
        return likelihood, starts
    found = sorted(found, key=lambda start: start.deviance)
    spread = _Spread.of(white, found[0], noise.covariance)
    angles = white.angle(np.stack([starts[0].point, found[0].point]))
    led, least = white.project(angles)
    if not spread.fixed.size or spread.holds(led - least):
        return likelihood, starts
    missing = likelihood.reduced.angle - angles[1]
    kept = replace(
        likelihood,
        noise=replace(
            noise, words=f"{noise.words}; fitted by least squares, which these errors spread"
        ),
        least_squares=LeastSquares(
            left=missing - white.offset(missing),
            weights=spread.weights(noise.white_sd),
            squares=spread.variance * likelihood.block_degrees,
        ),
    )
    modes = descend_all(kept, [start.point for start in found])
    return kept, sorted(modes, key=lambda start: start.deviance)
