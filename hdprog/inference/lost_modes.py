"""Modes that the search had found and that a frozen proposal has lost.

The proposal is fitted to walkers, time and again where sampling is slow. A mode that few of them
are in at the time gets little of it; more walkers then leave that mode than find back into its
core, the next fit sees fewer still, and in the end all ensembles are without it. They share the
proposal and agree with each other, so that no R-hat and no autocorrelation time tells.

What tells is the posterior where the search had been. A mode whose best point has much more of the
posterior than of the proposal gets walkers of its own, which know nothing of the proposal. With
mixtures fitted to them the posterior is weighed once more, by importance (balance heuristic of
Veach and Guibas, SIGGRAPH 1995): what the proposal hardly reaches must have the share of the
posterior that the chains have given it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hdprog.inference.mixture_proposal import Mixture, fit_mixture
from hdprog.inference.sampler import (
    WALKERS,
    EnsembleState,
    RidgePosterior,
    fresh_random_state,
    initial_states,
    sample_ensembles,
    spaced_positions,
)
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.parameters import FloatArray

_HARDLY = math.log(100.0)  # posterior over proposal: a walker is held up for a hundred draws
# Of the walkers of a mode, and more where those leave it open; the second half of them counts.
_STEPS = (200, 400)
_COMPONENTS = 3
_TAIL_DEGREES = 6.0  # of Student's t: walkers so few have not seen their mode's tails
_DRAWN = 2000  # of the proposal, and of each mode's own mixture
_FEW, _MORE = 500, 2000  # positions of the chains
_RETURNED = 2000
# Share of the posterior that is out of the proposal's reach: what chains may fall short of.
_LEAST, _TIMES = 0.03, 3.0
_WORTH = 5.0  # effective draws there, below which the share is one draw's accident


def lost_modes(
    density: RidgePosterior,
    mixture: Mixture,
    chains: FloatArray,
    modes: Sequence[StartingPoint],
    random_state: Any,
) -> FloatArray | None:
    """Draws of modes that a proposal has lost, to fit it to; None where there are none.

    Parameters
    ----------
    density : log density of the posterior
    mixture : the frozen proposal
    chains : (ensembles, steps, walkers, dimensions) sampled with it
    modes : of the posterior, as walkers began in them
    random_state : of a generator, which is left as it is

    Returns
    -------
    (draws, dimensions), or None
    """
    # The mean of proposal over posterior, over draws of the posterior, is one over its integral.
    rough = -_log_mean(-_excess(density, mixture, spaced_positions(chains, _FEW)))
    best = np.array([density.position(mode.point) for mode in modes])
    doubtful = np.flatnonzero(_excess(density, mixture, best) - rough > _HARDLY)
    if doubtful.size == 0:
        return None
    random = np.random.RandomState()
    random.set_state(random_state)
    rng = np.random.default_rng(random.randint(0, 2**32, size=4, dtype=np.uint32).tolist())
    walkers = [
        initial_states(density, [modes[index]], rng, ensembles=1, walkers=WALKERS)[0].position
        for index in doubtful.tolist()
    ]
    state = EnsembleState(np.concatenate(walkers), fresh_random_state(rng))
    for steps in _STEPS:
        stretch = sample_ensembles(density, state, steps)
        late, state = stretch.chains[:, steps // 2 :], stretch.state
        draws = late.reshape(len(late), -1, late.shape[-1])
        fitted = [fit_mixture(one, _COMPONENTS, rng) for one in draws]
        own = [replace(one, degrees=_TAIL_DEGREES) for one in fitted]
        share, worth, level = _out_of_reach(density, mixture, own, random)
        given = np.mean(
            _excess(density, mixture, spaced_positions(chains, _MORE)) - level > _HARDLY
        )
        if share < _LEAST + _TIMES * given:
            return None
        if worth >= _WORTH:
            return spaced_positions(draws, _RETURNED)
    return None


def _out_of_reach(
    density: RidgePosterior, mixture: Mixture, own: list[Mixture], random: np.random.RandomState
) -> tuple[float, float, float]:
    """Share of the posterior beyond the proposal, its effective draws, and the log integral."""
    drawn = [mixture, *own]
    total = _DRAWN * len(drawn)
    position = np.concatenate([one.draw(_DRAWN, random) for one in drawn])
    values = density(position)
    position, values = position[np.isfinite(values)], values[np.isfinite(values)]
    log_weight = values - _log_mean(np.array([one.log_density(position) for one in drawn]))
    weight = np.exp(log_weight - log_weight.max())
    level = float(log_weight.max() + np.log(weight.sum() / total))
    there = weight[values - mixture.log_density(position) - level > _HARDLY]
    worth = float(there.sum() ** 2 / (there**2).sum()) if there.size else 0.0
    return float(there.sum() / weight.sum()), worth, level


def _excess(density: RidgePosterior, mixture: Mixture, position: FloatArray) -> FloatArray:
    """Log of posterior over proposal, (positions,), the posterior not normalised."""
    return np.asarray(density(position) - mixture.log_density(position))


def _log_mean(values: FloatArray) -> FloatArray:
    """Log of the mean over the first axis, of logs."""
    return np.asarray(np.logaddexp.reduce(values, axis=0) - math.log(len(values)))
