"""Effects integrated out while the drive model is sampled, then drawn.

Near their best values ẑ the angle is linear in the effects' coordinates,
f(x, z) ≈ f(x, ẑ) + E (z − ẑ). With their standard Gaussian prior, z is integrated out exactly: −E ẑ
joins the model and E Eᵀ the noise. The sampler then sees nine dimensions whatever effects there
are. Afterwards z is drawn from its exact conditional distribution. What the linearisation costs is
measured by importance weights against the exact density, with their Pareto k (Vehtari et al.,
J. Mach. Learn. Res. 25 (2024) 72).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.lazy_arviz import arviz
from hdprog.inference.likelihood import COUNT, HeldEffects, LoopLikelihood
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.parameters import FloatArray

PARETO_K_LIMIT = 0.7
_WEIGHED = 1000


@dataclass(frozen=True)
class LinearisedEffects:
    """The likelihood with its effects linearised about a mode.

    Attributes
    ----------
    exact : with the effects' coordinates in a point
    sampled : without them, nine coordinates
    scale : that noise scale
    """

    exact: LoopLikelihood
    sampled: LoopLikelihood
    scale: float

    @property
    def features(self) -> FloatArray:
        """(blocks, k) E over the noise scale at the mode."""
        assert self.sampled.held is not None
        return self.sampled.held.features

    @staticmethod
    def about(exact: LoopLikelihood, start: StartingPoint) -> LinearisedEffects:
        """Linearise about a mode of the exact likelihood."""
        best = start.point[COUNT + 1 :]
        points = np.tile(start.point, (2 * best.size, 1))
        step = 1e-4 * np.eye(best.size)
        points[: best.size, COUNT + 1 :] += step
        points[best.size :, COUNT + 1 :] -= step
        angles = exact.angle(points)
        derivative = (angles[: best.size] - angles[best.size :]).T / 2e-4
        scale = float(np.sqrt(start.variance))
        held = HeldEffects(best, -derivative @ best, derivative / scale)
        return LinearisedEffects(exact, replace(exact, held=held), scale)

    def complete(
        self, points: FloatArray, offset: FloatArray, scale: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Points (draws, size) with the effects drawn, given points (draws, 9) without.

        Parameters
        ----------
        points, offset, scale : (draws, 9), (draws,) in rad, (draws,)
        rng : source of randomness
        """
        sampled = self.sampled
        left = sampled.reduced.angle - sampled.angle(points) - offset[:, None]
        pulled = sampled.whiten(self.features.T).T
        mean = sampled.whiten(left) @ pulled
        spread = np.eye(self.features.shape[1]) - pulled.T @ pulled
        values, vectors = np.linalg.eigh(0.5 * (spread + spread.T))
        factor = vectors * np.sqrt(np.maximum(values, 0.0))
        drawn = rng.standard_normal(mean.shape) @ factor.T
        return np.hstack([points, (mean + scale[:, None] * drawn) / self.scale])

    def pareto_k(self, points: FloatArray, offset: FloatArray, scale: FloatArray) -> float:
        """Pareto k of the exact density over the linearised one, at complete points."""
        chosen = np.linspace(0, len(points) - 1, min(len(points), _WEIGHED)).astype(int)
        points, offset, scale = points[chosen], offset[chosen], scale[chosen]
        effects = points[:, COUNT + 1 :]
        noise = self.exact.noise
        exact = self.exact.reduced.angle - self.exact.angle(points) - offset[:, None]
        linear = self.sampled.angle(points[:, : COUNT + 1]) + effects @ (
            self.features.T * self.scale
        )
        linear = self.exact.reduced.angle - linear - offset[:, None]
        squares = [np.sum(noise.whiten(left) ** 2, axis=1) / scale**2 for left in (exact, linear)]
        log_ratio = -0.5 * (squares[0] - squares[1])
        log_ratio = np.where(np.isfinite(log_ratio), log_ratio, -1e6)
        _, k = arviz().psislw(log_ratio - log_ratio.max())
        return float(k)
