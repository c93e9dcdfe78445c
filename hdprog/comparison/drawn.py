"""Draws of any model's posterior, the drive model's and the others' alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.inference.diagnostics import Diagnostics
from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.fit_other import OtherPosterior, ensembles_in_words, fit_other
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, settle_noise
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.other_models import BY_ID
from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class Drawn:
    """What the posterior of any model has; attributes as in `OtherPosterior`."""

    likelihood: LoopLikelihood
    starts: tuple[StartingPoint, ...]
    chains: FloatArray
    offset: FloatArray
    scale: FloatArray
    diagnostics: Diagnostics
    converged: bool
    method: str
    sampling: Mapping[str, float]

    @staticmethod
    def of(
        posterior: Posterior | OtherPosterior, starts: Sequence[StartingPoint], method: str
    ) -> Drawn:
        """What both kinds of posterior have alike; modes and how it was sampled beside."""
        return Drawn(
            posterior.likelihood,
            tuple(starts),
            posterior.chains,
            posterior.offset,
            posterior.noise_scale,
            posterior.diagnostics,
            posterior.converged,
            method,
            posterior.sampling,
        )

    def flat(self, draws: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Evenly chosen points (draws, size), offsets and noise scales (draws,)."""
        size = self.chains.shape[-1]
        total = int(np.prod(self.chains.shape[:3]))
        points = self.chains.transpose(0, 2, 1, 3).reshape(total, size)
        chosen = np.linspace(0, total - 1, min(draws, total)).astype(np.intp)
        offset = self.offset.transpose(0, 2, 1).reshape(-1)[chosen]
        return points[chosen], offset, self.scale.transpose(0, 2, 1).reshape(-1)[chosen]


def drive_draws(prepared: Prepared, rng: np.random.Generator, plan: SamplingPlan) -> Drawn:
    """Posterior of the drive model on a prepared record, by its likelihood as the others' are.

    Least squares in its place would have no density to be ranked by.
    """
    likelihood, starts = settle_noise(prepared.likelihood, prepared.starts, rng)
    posterior = sample_posterior(prepared, likelihood, starts, rng, plan=plan, to_readings=False)
    return Drawn.of(posterior, starts, ensembles_in_words(posterior.sampling))


def other_draws(
    prepared: Prepared, model_id: str, rng: np.random.Generator, plan: SamplingPlan
) -> Drawn:
    """Posterior of another model on a prepared record."""
    posterior = fit_other(prepared, BY_ID[model_id], rng, plan)
    return Drawn.of(posterior, posterior.starts, posterior.method)
