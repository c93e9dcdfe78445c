"""Sampling of one loop's posterior by independent emcee ensembles.

Warm-up moves: differential evolution (ter Braak 2006; Nelson et al. 2014), one step in ten with
unit scale so that walkers hop between modes, and the affine stretch move (Goodman & Weare 2010).
After the warm-up most steps are independence proposals from a frozen mixture, and most others are
short steps by the covariance that the mixture has where a walker stands: these lead out of what the
mixture hardly proposes. The mixture is fitted to what chains and proposals tell, see
`weighed_proposals`. Where a record ends about the teeth's threshold, some steps redraw that one.
emcee 3.1.6's snooker move is not used: it does not leave its target distribution unchanged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.covariance_root import root_of
from hdprog.inference.likelihood import COUNT, LoopLikelihood, sigmoid
from hdprog.inference.mixture_proposal import LocalProposal, Mixture
from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained
from hdprog.inference.starting_points import StartingPoint
from hdprog.inference.threshold_redraw import ThresholdRedraw
from hdprog.inference.weighed_proposals import WeighedProposals
from hdprog.physics.parameters import FloatArray

ENSEMBLES = 4
WALKERS = 24
INDEPENDENT = 0.85  # share of the steps behind the first part of the warm-up
_LOCAL = 0.8  # of the others: along a ridge they are taken five times as often as evolution's
_REDRAWN = 0.1
LogDensity = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class RidgePosterior:
    """Log posterior density over ridge coordinates and the initial slip's fraction.

    The fraction, not its logit: where the record says nothing of it, walkers would stay out of the
    logit's long tails for as long as they run. A class, not a closure, so that it can travel to
    another process.

    Attributes
    ----------
    likelihood : of the loop
    temperature : of the likelihood; above one the walkers see what lies beside the main mode
    """

    likelihood: LoopLikelihood
    temperature: float = 1.0

    def points(self, position: FloatArray) -> FloatArray:
        """Points of the likelihood, (draws, size), of positions (draws, size)."""
        return self._points(position)[0]

    def __call__(self, position: FloatArray) -> FloatArray:
        """Log density (draws,) at positions (draws, size); −inf outside the support."""
        points, log_jacobian = self._points(position)
        with np.errstate(all="ignore"):
            density = log_jacobian + self.likelihood.log_prior(points)
            density += self.likelihood.log_likelihood(points) / self.temperature
            inside = np.isfinite(density) & self.likelihood.supported(points)
        return np.where(inside, density, -np.inf)

    def position(self, point: FloatArray) -> FloatArray:
        """Position (size,) of one point (size,)."""
        likelihood = self.likelihood
        ridge = from_unconstrained(point[None, :COUNT], *likelihood.ridge_frame)[0]
        return np.concatenate([ridge, sigmoid(point[COUNT : COUNT + 1]), point[COUNT + 1 :]])

    def _points(self, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        unconstrained, log_jacobian = to_unconstrained(
            position[:, :COUNT], *self.likelihood.ridge_frame
        )
        fraction = position[:, COUNT]
        inside = (fraction > 0) & (fraction < 1)
        with np.errstate(invalid="ignore", divide="ignore"):
            log_fraction, log_rest = np.log(fraction), np.log1p(-fraction)
        log_jacobian = np.where(inside, log_jacobian - log_fraction - log_rest, -np.inf)
        points = np.hstack([unconstrained, position[:, COUNT:]])
        points[:, COUNT] = np.where(inside, log_fraction - log_rest, 0.0)
        return points, log_jacobian


@dataclass(frozen=True)
class EnsembleState:
    """Where ensembles that run side by side stand between two stretches of sampling.

    Attributes
    ----------
    position : (ensembles, walkers, dimensions)
    random_state : of their generator
    """

    position: FloatArray
    random_state: Any


@dataclass(frozen=True)
class Stretch:
    """A stretch of sampling.

    Attributes
    ----------
    chains : (ensembles, steps, walkers, dimensions)
    accepted : share of accepted proposals
    state : to run on from
    proposed : the independent proposals; None where there were none
    evaluations : of the target
    """

    chains: FloatArray
    accepted: float
    state: EnsembleState
    proposed: WeighedProposals | None
    evaluations: int


def moves(
    ensembles: int,
    mixture: Mixture | None = None,
    redraw: ThresholdRedraw | None = None,
    independent: float = INDEPENDENT,
) -> list[tuple[Any, float]]:
    """The moves in use with their weights; their stationarity is tested on known targets.

    Parameters
    ----------
    ensembles : how many run side by side
    mixture : frozen proposal of the steps after the warm-up, or None during it
    redraw : of thresholds beyond the record, or None where walkers have none
    independent : share of the steps that draw from the mixture, where there is one
    """
    from emcee.moves import DEMove, MHMove, StretchMove

    from hdprog.inference.independent_steps import IndependentSteps
    from hdprog.inference.side_by_side import SideBySide

    local = [(DEMove(), 0.8), (DEMove(gamma0=1.0), 0.1), (StretchMove(), 0.1)]
    each = [(SideBySide(move, ensembles), weight) for move, weight in local]
    if mixture is not None:
        each = _with(MHMove(LocalProposal(mixture)), _LOCAL, each)
        each = _with(IndependentSteps(mixture), independent, each)
    return each if redraw is None else _with(MHMove(redraw), _REDRAWN, each)


def _with(move: Any, share: float, others: list[tuple[Any, float]]) -> list[tuple[Any, float]]:
    """Moves of which one has a share."""
    return [(move, share)] + [(other, (1 - share) * weight) for other, weight in others]


def sample_ensembles(
    log_density: LogDensity,
    state: EnsembleState,
    steps: int,
    mixture: Mixture | None = None,
    redraw: ThresholdRedraw | None = None,
    independent: float = INDEPENDENT,
) -> Stretch:
    """Run independent ensembles on, side by side.

    Parameters
    ----------
    log_density : (draws, dimensions) → (draws,)
    state : walkers' positions and the generator's state
    steps : steps of every ensemble
    mixture : frozen proposal, or None during the warm-up
    redraw, independent : as in `moves`
    """
    from emcee import EnsembleSampler

    from hdprog.inference.independent_steps import IndependentSteps

    ensembles, walkers, dimensions = state.position.shape
    used = moves(ensembles, mixture, redraw, independent)
    sampler = EnsembleSampler(
        ensembles * walkers,
        dimensions,
        log_density,
        moves=used,
        vectorize=True,
    )
    # emcee's wrapper prints to standard output whatever ends a call, an interruption included.
    sampler.log_prob_fn = log_density
    # emcee seeds itself from NumPy's global state unless told otherwise.
    sampler.random_state = state.random_state
    flat = state.position.reshape(-1, dimensions)
    sampler.run_mcmc(flat, steps, skip_initial_state_check=True)
    chains = sampler.get_chain().reshape(steps, ensembles, walkers, dimensions).swapaxes(0, 1)
    following = EnsembleState(chains[:, -1], sampler.random_state)
    proposed, rounds = None, steps + 1  # where walkers begin, too
    for move, _ in used:
        if isinstance(move, IndependentSteps):
            proposed, rounds = move.proposed, rounds + move.steps_ahead
    accepted = float(np.mean(sampler.acceptance_fraction))
    return Stretch(chains, accepted, following, proposed, rounds * ensembles * walkers)


def fresh_random_state(rng: np.random.Generator) -> Any:
    """State of a legacy generator, as emcee wants it, seeded from ours."""
    seed: NDArray[np.uint32] = rng.integers(0, 2**32, size=8, dtype=np.uint32)
    return np.random.RandomState(
        np.random.MT19937(np.random.SeedSequence(seed.tolist()))
    ).get_state()


def spaced_positions(chains: FloatArray, most: int) -> FloatArray:
    """At most so many positions (positions, dimensions) of chains (..., dimensions), evenly."""
    pooled = chains.reshape(-1, chains.shape[-1])
    chosen = np.linspace(0, len(pooled) - 1, min(len(pooled), most)).astype(int)
    return np.asarray(pooled[chosen])


def worth_walkers(starts: list[StartingPoint]) -> list[StartingPoint]:
    """Modes, best first, without those that are much worse than the best."""
    return [start for start in starts if start.deviance < starts[0].deviance + 12.0]


def initial_states(
    posterior: RidgePosterior,
    starts: list[StartingPoint],
    rng: np.random.Generator,
    parts: int = 1,
    ensembles: int = ENSEMBLES,
    walkers: int = WALKERS,
) -> list[EnsembleState]:
    """Overdispersed walkers around the modes, those much worse than the best left out.

    Each mode gets walkers in proportion to the mass of its Gaussian approximation.

    Parameters
    ----------
    posterior, starts : the posterior and its modes, best first
    rng : source of randomness
    parts : into how many the ensembles are divided, so that each may run in a process of its own
    ensembles, walkers : how many in all, and in each

    Returns
    -------
    one EnsembleState a part
    """
    size = posterior.likelihood.size
    near = worth_walkers(starts)
    mass = np.array(
        [0.5 * np.linalg.slogdet(start.covariance)[1] - 0.5 * start.deviance for start in near]
    )
    weight = np.exp(mass - mass.max()) + 0.05
    weight /= weight.sum()
    factors = [root_of(start.covariance) for start in near]
    positions = []
    for _ in range(ensembles):
        kept: list[FloatArray] = []
        spread = 1.0
        while len(kept) < walkers:
            mode = int(rng.choice(len(near), p=weight))
            drawn = near[mode].point + spread * (factors[mode] @ rng.standard_normal(size))
            position = posterior.position(drawn)
            if np.isfinite(posterior(position[None, :])[0]):
                kept.append(position)
            else:
                spread *= 0.97
        positions.append(np.array(kept))
    return [
        EnsembleState(part, fresh_random_state(rng))
        for part in np.array_split(np.array(positions), parts)
    ]
