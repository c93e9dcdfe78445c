"""The loops' likelihoods with the scatter of remounting integrated out.

Of a loop in information form (Λ, η) and scatter e ~ N(0, r²D), D diagonal, the state x behind it
keeps Λ̃ = Λ(I + r²DΛ)⁻¹. In the eigenvectors V of √D Λ √D with eigenvalues δ this is

    Λ̃ = D^{−½} V diag(δ/(1 + r²δ)) Vᵀ D^{−½},   η̃ = D^{−½} V diag(1/(1 + r²δ)) Vᵀ √D η,

one decomposition a loop for every r.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.inference.information import Linearised
from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class Observations:
    """What the loops say of the drive's state at each test.

    Attributes
    ----------
    basis : (tests, n, n) D^{−½}V
    strength : (tests, n) δ
    pull : (tests, n) Vᵀ√D η
    """

    basis: FloatArray
    strength: FloatArray
    pull: FloatArray

    @staticmethod
    def of(loops: Sequence[Linearised], scales: FloatArray) -> Observations:
        """From linearised loops.

        Parameters
        ----------
        loops : (tests) in order
        scales : (n,) relative size of scatter, √D
        """
        precision = np.stack([loop.precision for loop in loops])
        information = np.stack([loop.information for loop in loops])
        strength, vectors = np.linalg.eigh(scales[:, None] * precision * scales)
        strength = np.maximum(strength, 0.0)
        pull = np.einsum("jik,ji->jk", vectors, information * scales)
        return Observations(vectors / scales[:, None], strength, pull)

    def behind_scatter(self, scatter: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Information on the state x(t) behind the scatter.

        Parameters
        ----------
        scatter : (draws,) r

        Returns
        -------
        Λ̃ (draws, times, n, n), η̃ (draws, times, n) and the log of the factor that integrating
        the scatter leaves, (draws,)
        """
        variance = scatter[:, None, None] ** 2
        damped = 1.0 / (1.0 + variance * self.strength)
        precision = (self.basis * (self.strength * damped)[:, :, None, :]) @ np.swapaxes(
            self.basis, -1, -2
        )
        information = np.einsum("tik,dtk->dti", self.basis, self.pull * damped)
        log_factor = 0.5 * np.sum(np.log(damped) + variance * damped * self.pull**2, axis=(1, 2))
        return precision, information, log_factor

    def draw_noise(self, scatter: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Random information (draws, times, n) with mean zero and covariance Λ̃."""
        variance = scatter[:, None, None] ** 2
        size = np.sqrt(self.strength / (1.0 + variance * self.strength))
        noise = size * rng.standard_normal(size.shape)
        return np.asarray(np.einsum("tik,dtk->dti", self.basis, noise))

    def draw_measured(
        self, states: FloatArray, scatter: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Draw what a test met, x(t) + e, given the state (draws, times, n) and the loop."""
        scales = np.sqrt(1.0 / np.sum(self.basis**2, axis=-1))
        vectors = self.basis * scales[..., None]
        along = np.einsum("tik,dti->dtk", vectors, states / scales)
        weight = 1.0 / (self.strength + scatter[:, None, None] ** -2)
        mean = weight * (self.pull + along * scatter[:, None, None] ** -2)
        drawn = mean + np.sqrt(weight) * rng.standard_normal(mean.shape)
        return np.asarray(np.einsum("tik,dtk->dti", vectors, drawn) * scales)
