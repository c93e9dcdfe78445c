"""A check of the reference by another principle: nested sampling with dynesty.

Live points shrink from the whole prior, in the unit cube of its distribution functions, towards
the largest likelihood (Skilling, Bayesian Analysis 1 (2006) 833; Speagle, MNRAS 493 (2020) 3132).
Neither hdprog's ridge coordinates nor any gradient is used.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from scipy.special import ndtri

from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.physics.parameters import FloatArray
from tests.benchmarks.modes.fused import LogLikelihood

LIVE_POINTS, WALKS = 2500, 30
"""Many points and short walks: fewer points on longer paths (1000, slices) lost modes on the way
that held a tenth of the mass."""
REALISATIONS = 30
_OUTSIDE = -1e300


@dataclass(frozen=True)
class Nested:
    """What nested sampling found.

    Attributes
    ----------
    points, weights : (draws, 9) and (draws,) of sum one
    realisations : list of points and weights as other runs would have given them, for errors
    log_evidence, error : of L without its constant, and dynesty's standard error
    calls : of the likelihood
    """

    points: FloatArray
    weights: FloatArray
    realisations: list[tuple[FloatArray, FloatArray]]
    log_evidence: float
    error: float
    calls: int

    @property
    def effective(self) -> float:
        """Effective number of draws by the weights alone."""
        return float(1 / (self.weights**2).sum())


def nested(
    likelihood: LoopLikelihood,
    log_likelihood: LogLikelihood,
    rng: np.random.Generator,
    live_points: int = LIVE_POINTS,
) -> Nested:
    """Run dynesty on one loop.

    Parameters
    ----------
    likelihood : of the loop
    log_likelihood : the same, compiled
    rng : source of randomness
    live_points : how many
    """
    dynesty = import_module("dynesty")
    utils = import_module("dynesty.utils")
    mean, sd = likelihood.prior.mean, likelihood.prior.sd

    def prior_transform(cube: FloatArray) -> FloatArray:
        point = np.empty(COUNT + 1)
        point[:COUNT] = mean + sd * ndtri(cube[:COUNT])
        point[COUNT] = np.log(cube[COUNT] / (1 - cube[COUNT]))
        return point

    def one(point: FloatArray) -> float:
        return max(float(log_likelihood(point[None, :])[0]), _OUTSIDE)

    sampler = dynesty.NestedSampler(
        one,
        prior_transform,
        COUNT + 1,
        nlive=live_points,
        bound="multi",
        sample="rwalk",
        walks=WALKS,
        rstate=rng,
    )
    sampler.run_nested(dlogz=0.01, print_progress=False)
    results = sampler.results
    # Both sources of error: which points there are, and what prior volume lies between them.
    others = [
        utils.jitter_run(utils.resample_run(results, rstate=rng), rstate=rng)
        for _ in range(REALISATIONS)
    ]
    return Nested(
        points=np.asarray(results.samples),
        weights=_weights(results),
        realisations=[(np.asarray(other.samples), _weights(other)) for other in others],
        log_evidence=float(results.logz[-1]),
        error=float(results.logzerr[-1]),
        calls=int(np.sum(results.ncall)),
    )


def _weights(results: Any) -> FloatArray:
    weights = np.asarray(results.importance_weights())
    return np.asarray(weights / weights.sum())
