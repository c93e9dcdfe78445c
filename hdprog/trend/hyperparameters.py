"""Sampling of the hyperparameters: a handful of numbers, states integrated out exactly.

Every hyperparameter is sampled as a standard normal deviate, so the prior is a unit Gaussian.
Several independent ensembles run as for the loops: differential evolution and stretch moves first,
then mostly proposals from a mixture fitted to these and frozen. Where the tests tell little wander,
they tell pace and clock closely: a funnel, whose neck holds up walkers that the mixture does not
know. So it is fitted anew to every stretch that has not converged, which is dropped. They start
from an importance-resampled Laplace approximation around the mode.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hdprog.inference.diagnostics import diagnose
from hdprog.inference.mixture_proposal import Mixture, fit_mixture
from hdprog.inference.sampler import (
    EnsembleState,
    Stretch,
    fresh_random_state,
    sample_ensembles,
    spaced_positions,
)
from hdprog.physics.parameters import FloatArray

ENSEMBLES = 4
WALKERS = 20
RHAT_LIMIT = 1.02
"""On a few hundred effective draws, R-hat itself scatters by about 0.01."""
_FIRST_COMPONENTS, _COMPONENTS = 2, 6  # of the mixture, in the burn-in and behind it
_CHAIN_DRAWS, _PROPOSALS = 3000, 6000  # that it is fitted to, at most
_DIFFERENCE = 1e-2
_BOTTOM = -1e12  # stands for minus infinity where differences are taken

LogDensity = Callable[[FloatArray], FloatArray]
"""(points, dimensions) → (points,)."""


@dataclass(frozen=True)
class HyperparameterDraws:
    """Draws of the deviates with their diagnostics.

    Attributes
    ----------
    chains : (ensembles, steps, walkers, dimensions)
    rhat, ess_bulk, ess_tail : worst over the dimensions
    converged : R-hat and effective sizes within their limits
    proposal : fitted to them, and to what was proposed to them; None where nothing was
    """

    chains: FloatArray
    rhat: float
    ess_bulk: float
    ess_tail: float
    converged: bool
    proposal: Mixture | None = None

    @property
    def flat(self) -> FloatArray:
        """(draws, dimensions)."""
        return self.chains.reshape(-1, self.chains.shape[-1])

    def thinned(self, draws: int, rng: np.random.Generator) -> FloatArray:
        """(draws, dimensions) drawn without replacement where there are enough."""
        flat = self.flat
        return flat[rng.choice(len(flat), draws, replace=draws > len(flat))]


def mode_of(log_density: LogDensity, starts: FloatArray) -> FloatArray:
    """(dimensions,) highest point reached from starts (points, dimensions)."""
    from scipy.optimize import minimize

    dimensions = starts.shape[1]
    shift = _DIFFERENCE * np.eye(dimensions)

    def negative(point: FloatArray) -> tuple[float, FloatArray]:
        values = log_density(np.concatenate([point[None], point + shift, point - shift]))
        values = np.maximum(values, _BOTTOM)
        rise = (values[1 : dimensions + 1] - values[dimensions + 1 :]) / (2 * _DIFFERENCE)
        return -float(values[0]), -rise

    best = starts[np.argsort(-log_density(starts))[:2]]
    found = [
        minimize(negative, point, jac=True, method="L-BFGS-B", bounds=[(-4, 4)] * dimensions)
        for point in best
    ]
    return np.asarray(min(found, key=lambda result: float(result.fun)).x)


def _laplace_spread(log_density: LogDensity, point: FloatArray) -> FloatArray:
    """(dimensions, dimensions) root of the covariance at a mode; never wider than the prior.

    Beyond an edge of what is believed the density is taken as on the mode's other side: its fall
    there is no curvature, by which walkers would begin, and stay, in one place.
    """
    dimensions = point.size
    size = 0.05
    shift = size * np.eye(dimensions)
    pairs = point + shift[:, None] + shift[None, :]
    crossed = point + shift[:, None] - shift[None, :]
    both, one, other, neither = (
        log_density(group.reshape(-1, dimensions)).reshape(pairs.shape[:2])
        for group in (pairs, crossed, 2 * point - crossed, 2 * point - pairs)
    )
    both, neither = _mirrored(both, neither)
    one, other = _mirrored(one, other)
    curvature = -(both - one - other + neither) / (4 * size**2)
    strength, vectors = np.linalg.eigh(0.5 * (curvature + curvature.T))
    return np.asarray(vectors / np.sqrt(np.maximum(strength, 1.0)))


def _mirrored(one: FloatArray, opposite: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values on opposite sides of a mode, where the density ends those of the other side."""
    one, opposite = np.maximum(one, _BOTTOM), np.maximum(opposite, _BOTTOM)
    return np.where(one > _BOTTOM, one, opposite), np.where(opposite > _BOTTOM, opposite, one)


def starting_walkers(
    log_density: LogDensity, around: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """(ensembles, walkers, dimensions): widened Laplace draws, resampled by importance."""
    dimensions = around.size
    count = ENSEMBLES * WALKERS
    deviates = rng.standard_normal((6 * count, dimensions))
    points = around + 1.5 * deviates @ _laplace_spread(log_density, around).T
    log_weight = log_density(points) + 0.5 * np.sum(deviates**2, axis=1)
    # Gumbel's trick: a weighted draw without replacement, so that no two walkers coincide.
    # The root tempers the weights: the ensembles start wider than they should end.
    keys = 0.5 * log_weight + rng.gumbel(size=log_weight.size)
    chosen = rng.permutation(np.argsort(-keys)[:count])
    return np.asarray(points[chosen].reshape(ENSEMBLES, WALKERS, dimensions))


@dataclass(frozen=True)
class Effort:
    """How long to sample: steps of the first stretch and of the last, wanted ESS."""

    steps: int
    largest_steps: int
    ess: float


FULL = Effort(200, 1600, 400.0)
QUICK = Effort(200, 1600, 200.0)


def sample(
    log_density: LogDensity,
    walkers: FloatArray,
    burn_in: int,
    steps: int,
    rng: np.random.Generator,
    effort: Effort | None = None,
    proposal: Mixture | None = None,
) -> HyperparameterDraws:
    """Run the ensembles, for twice as long each time that they have not converged.

    Parameters
    ----------
    log_density : vectorised
    walkers : (ensembles, walkers, dimensions)
    burn_in, steps : dropped steps, behind each half of which the proposal is fitted, and kept ones
    rng : source of randomness
    effort : how far to go on; the kept steps alone if left out
    proposal : fitted to draws of a density that is much like this one; None where there are none
    """
    state = EnsembleState(walkers, fresh_random_state(rng))
    components = _FIRST_COMPONENTS if proposal is None else _COMPONENTS
    for share in (burn_in // 2, burn_in - burn_in // 2):
        stretch = sample_ensembles(log_density, state, share, proposal)
        late = stretch.chains[:, share // 2 :]
        state, proposal = stretch.state, _fitted(late, stretch, components, rng)
    while True:
        stretch = sample_ensembles(log_density, state, steps, proposal)
        state, proposal = stretch.state, _fitted(stretch.chains, stretch, _COMPONENTS, rng)
        draws = _diagnosed(stretch.chains, 0.0 if effort is None else effort.ess, proposal)
        steps *= 2
        if draws.converged or effort is None or steps > effort.largest_steps:
            return draws


def _fitted(
    chains: FloatArray, stretch: Stretch, components: int, rng: np.random.Generator
) -> Mixture:
    """A proposal fitted to chains, and to all that was proposed in a stretch."""
    seen = spaced_positions(chains, _CHAIN_DRAWS)
    if stretch.proposed is not None:
        seen = np.concatenate([seen, stretch.proposed.resampled(_PROPOSALS, rng)])
    return fit_mixture(seen, components, rng)


def _diagnosed(chains: FloatArray, ess_limit: float, proposal: Mixture) -> HyperparameterDraws:
    """Diagnostics across ensembles."""
    found = diagnose(chains)
    rhat = float(found.rhat.max())
    bulk, tail = float(found.ess_bulk.min()), float(found.ess_tail.min())
    converged = rhat < RHAT_LIMIT and min(bulk, tail) >= ess_limit
    return HyperparameterDraws(chains, rhat, bulk, tail, converged, proposal)
