"""Ensemble slice sampling by zeus."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

from hdprog.physics.parameters import FloatArray
from tests.benchmarks.samplers.log_density import batched, peer
from tests.benchmarks.samplers.measuring import Found, Watch, effective_draws, points_of
from tests.benchmarks.samplers.posteriors import Target, sampler_seed

WALKERS = 48
DISCARDED = 0.25
"""Share of its steps that is left out as warm-up; its own guide leaves out half."""
_ROUND = 100


def zeus_slices(target: Target, bound: float) -> Found:
    """zeus with its default move, half of its walkers evaluated at once (`vectorize=True`)."""
    zeus = peer("zeus")

    # It draws from the generators that NumPy and Python share among everybody.
    seed = sampler_seed(target.index)
    np.random.seed(seed)  # noqa: NPY002
    random.seed(seed)
    watch, evaluations = Watch(), 0
    start: FloatArray | None = target.warm_starts(WALKERS)
    with watch("compile"):
        density = batched(target.density.ridge, WALKERS // 2)
        density(np.asarray(start)[: WALKERS // 2])

    def counted(positions: FloatArray) -> FloatArray:
        nonlocal evaluations
        evaluations += len(positions)
        return density(positions)

    sampler: Any = zeus.EnsembleSampler(
        WALKERS, target.likelihood.size, counted, vectorize=True, verbose=False
    )
    rounds = 0
    while True:
        with watch("run"):
            sampler.run_mcmc(start, _ROUND, progress=False)
            start = sampler.get_last_sample()
        rounds += 1
        late = watch.processor["run"] > bound
        if late or rounds % max(1, rounds // 5) == 0:
            chain = np.swapaxes(sampler.get_chain(), 0, 1)
            points = points_of(target, chain[:, int(DISCARDED * chain.shape[1]) :])
            effective = effective_draws(points)
            if late or effective.enough:
                return Found(points, effective, watch, evaluations=evaluations)
