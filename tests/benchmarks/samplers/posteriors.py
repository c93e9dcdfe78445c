"""The ten posteriors: loops of every kind of the calibration, two each, prepared as for a fit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.prepare import Prepared, prepare, settle_noise
from hdprog.inference.sampler import RidgePosterior, initial_states
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.parameters import FloatArray
from tests.benchmarks.calibration.loops import DRIVE, Drawn, draw, fit_rng

if TYPE_CHECKING:
    from tests.benchmarks.samplers.log_density import JaxPosterior

POSTERIORS = 10
_STARTS, _CHECK, _SAMPLER = range(3)  # streams of random numbers of one posterior
_SEED = 71


@dataclass(frozen=True)
class Target:
    """One posterior, ready to be sampled.

    Attributes
    ----------
    index, drawn, prepared : number, the loop with its truth, and the loop made ready
    likelihood : its noise white
    starts : its modes, best first
    """

    index: int
    drawn: Drawn
    prepared: Prepared
    likelihood: LoopLikelihood
    starts: list[StartingPoint]

    @property
    def posterior(self) -> RidgePosterior:
        """Log density of hdprog in ridge coordinates and the initial slip's fraction."""
        return RidgePosterior(self.likelihood)

    @cached_property
    def density(self) -> JaxPosterior:
        """The same in JAX, over the initial slip's logit."""
        from tests.benchmarks.samplers.log_density import JaxPosterior

        return JaxPosterior(self.likelihood)

    def warm_starts(self, walkers: int) -> FloatArray:
        """Peers' positions (walkers, 9) about the modes, drawn as those of hdprog's own walkers."""
        rng = random_numbers(self.index, _STARTS)
        states = initial_states(self.posterior, self.starts, rng, ensembles=1, walkers=walkers)
        return with_logit(states[0].position[0])


def with_logit(position: FloatArray) -> FloatArray:
    """Ridge positions (…, 9) that end in the initial slip's logit: peers need an unbounded space.

    hdprog samples the fraction itself between its bounds.
    """
    fraction = position[..., COUNT:]
    return np.concatenate([position[..., :COUNT], np.log(fraction / (1 - fraction))], axis=-1)


def prepared_target(index: int) -> tuple[Target, np.random.Generator]:
    """A posterior as a fit sees it, and the generator that the fit goes on with.

    Raises ValueError where the loop's noise is taken for correlated: peers have no such likelihood.
    """
    drawn, rng = draw(index), fit_rng(index)
    prepared = prepare(drawn.loop, DRIVE, rng, prior=drawn.prior)
    likelihood, starts = settle_noise(prepared.likelihood, prepared.starts, rng)
    if likelihood.noise.whitening is not None:
        raise ValueError(f"loop {index}: its white noise is taken for correlated; choose another")
    return Target(index, drawn, prepared, likelihood, starts), rng


def random_numbers(index: int, stream: int) -> np.random.Generator:
    """Random numbers of one posterior for one purpose."""
    return np.random.default_rng([_SEED, index, stream])


def check_rng(index: int) -> np.random.Generator:
    """Random numbers for the points that densities are compared at."""
    return random_numbers(index, _CHECK)


def sampler_seed(index: int) -> int:
    """Seed of the peers' samplers."""
    return int(random_numbers(index, _SAMPLER).integers(2**31))
