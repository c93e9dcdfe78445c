"""Nested sampling by dynesty."""

from __future__ import annotations

import io
import time
from contextlib import redirect_stderr, redirect_stdout
from typing import Any

import numpy as np
from scipy.special import ndtri

from hdprog.inference.likelihood import COUNT
from hdprog.physics.parameters import FloatArray
from tests.benchmarks.samplers.log_density import jax_modules, peer
from tests.benchmarks.samplers.measuring import WANTED, Effective, Found, Watch
from tests.benchmarks.samplers.posteriors import Target, sampler_seed

_OUTSIDE = -1e300


class _Late(Exception):
    """The bound was reached."""


def dynesty_nested(target: Target, bound: float) -> Found:
    """Dynamic nested sampling by random walks, 500 live points, until it counts enough draws.

    The method that it would choose below ten dimensions draws evenly from ellipsoids: on these
    posteriors that has found 40 effective draws in 100 seconds, so that it gets the walks that it
    chooses from ten dimensions on. It cannot start from modes, and evaluates one point at a time.
    Its draws are weighted and make no chain: their effective number is Kish's, bulk and tail alike.
    """
    jax, _ = jax_modules()
    dynesty = peer("dynesty")

    watch, evaluations = Watch(), 0
    prior, size = target.likelihood.prior, target.likelihood.size
    with watch("compile"):
        compiled = jax.jit(target.density.log_likelihood).lower(target.likelihood.prior_mean)
        likelihood = compiled.compile()
    started = time.process_time()

    def log_likelihood(point: FloatArray) -> float:
        nonlocal evaluations
        evaluations += 1
        if time.process_time() - started > bound:
            raise _Late
        value = float(likelihood(point))
        return value if np.isfinite(value) else _OUTSIDE

    def from_cube(cube: FloatArray) -> FloatArray:
        point = np.empty(size)
        point[:COUNT] = prior.mean + prior.sd * ndtri(cube[:COUNT])
        point[COUNT] = np.log(cube[COUNT] / (1 - cube[COUNT]))
        return point

    sampler: Any = dynesty.DynamicNestedSampler(
        log_likelihood,
        from_cube,
        size,
        sample="rwalk",
        rstate=np.random.default_rng(sampler_seed(target.index)),
    )
    late = False
    # It prints the trace of an exception that the likelihood raises.
    unread = io.StringIO()
    with watch("run"), redirect_stderr(unread), redirect_stdout(unread):
        try:
            sampler.run_nested(n_effective=WANTED, print_progress=False)
        except _Late:
            late = True
    results = sampler.results
    log_weights = np.asarray(results.logwt) - np.max(results.logwt)
    weights = np.exp(log_weights) / np.exp(log_weights).sum()
    # Broken off, it has not come to the posterior yet: its weights mean nothing.
    count = 0.0 if late else float(1 / np.sum(weights**2))
    return Found(
        points=np.asarray(results.samples)[None],
        effective=Effective(count, count, 0.0),
        watch=watch,
        evaluations=evaluations,
        weights=weights,
    )
