"""hdprog's own sampler, as a fit runs it."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import patch

import numpy as np

from hdprog.inference import until_converged
from hdprog.inference.diagnostics import Diagnostics, diagnose
from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.physics.parameters import FloatArray
from tests.benchmarks.samplers.measuring import Found, Watch, effective_draws
from tests.benchmarks.samplers.posteriors import Target, prepared_target


def hdprog(target: Target) -> Found:
    """Prepare the record and sample by the full plan until it stops of itself.

    Its diagnostics, thinning and the draws of offset and noise are part of its time; the
    preparation is a part of its own. A posterior keeps its chains thinned: the whole ones are taken
    where it counts its own effective draws.
    """
    watch, seen = Watch(), []

    def kept(chains: FloatArray) -> Diagnostics:
        seen.append(chains)
        return diagnose(chains)

    with patch.object(until_converged, "diagnose", kept):
        with watch("preparation"):
            again, rng = prepared_target(target.index)
        with watch("run"):
            posterior = sample_posterior(
                again.prepared, again.likelihood, again.starts, rng, plan=until_converged.FULL
            )
    ensembles, steps, walkers, size = seen[-1].shape
    points = np.swapaxes(seen[-1], 1, 2).reshape(ensembles * walkers, steps, size)
    effective = effective_draws(points)
    # Walkers are many and short: R-hat is across the ensembles, which know nothing of each other.
    across = float(posterior.diagnostics.rhat.max())
    return Found(
        points=points,
        effective=replace(effective, rhat=across),
        watch=watch,
        evaluations=int(posterior.sampling["evaluations"]),
        converged=posterior.converged,
    )


def preparation_evaluations(index: int) -> int:
    """Model curves that preparing a record takes, counted apart from its timing."""
    counted = 0
    angle = LoopLikelihood.angle

    def counting(likelihood: LoopLikelihood, points: FloatArray) -> FloatArray:
        nonlocal counted
        counted += len(points)
        return angle(likelihood, points)

    with patch.object(LoopLikelihood, "angle", counting):
        prepared_target(index)
    return counted
