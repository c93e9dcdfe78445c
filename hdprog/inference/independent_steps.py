"""An emcee move by independent proposals, those of several steps evaluated by one call.

Where a walker stands has no part in them, so that they can be drawn and evaluated before it gets
there: most of the cost of a density called with few positions is that of the call.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from emcee.moves import Move
from emcee.state import State

from hdprog.inference.mixture_proposal import Mixture
from hdprog.inference.weighed_proposals import ENOUGH, WeighedProposals
from hdprog.physics.parameters import FloatArray

_TOGETHER = 288  # positions: more hardly cost less each


class IndependentSteps(Move):  # type: ignore[misc]  # emcee has no types
    """Metropolis-Hastings steps of all walkers by a frozen mixture.

    Parameters
    ----------
    mixture : proposes
    """

    def __init__(self, mixture: Mixture) -> None:
        self.mixture = mixture
        # Of each step: positions, and their log density by the target and the mixture.
        self._ahead: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        # Where walkers stood last, and the mixture's log density there.
        self._stood = np.empty((0, 0))
        self._log_mixture = np.empty(0)
        self._told: list[WeighedProposals] = []

    @property
    def proposed(self) -> WeighedProposals | None:
        """What was proposed, taken or not, and enough of it; None before the first step."""
        return WeighedProposals.together(self._told)

    @property
    def steps_ahead(self) -> int:
        """How many steps are evaluated and not taken yet."""
        return len(self._ahead)

    def propose(self, model: Any, state: State) -> tuple[State, np.ndarray]:
        """Take one step; see `emcee.moves.MHMove.propose`."""
        walkers = len(state.coords)
        if not self._ahead:
            self._look_ahead(model, walkers)
        proposed = self._ahead.pop(0)
        self._follow(state.coords)
        here = (self._stood, state.log_prob, self._log_mixture)
        gain = (proposed[1] - proposed[2]) - (here[1] - here[2])
        taken = gain > np.log(model.random.random_sample(walkers))
        for old, new in zip(here, proposed, strict=True):
            old[taken] = new[taken]
        state.coords[taken] = proposed[0][taken]
        return state, taken

    def _look_ahead(self, model: Any, walkers: int) -> None:
        """Propose for as many steps as one call is worth.

        Not by emcee's own way to the density, which looks at every number by itself.
        """
        steps = -(-_TOGETHER // walkers)
        positions = self.mixture.draw(steps * walkers, model.random)
        target, mixture = model.log_prob_fn(positions), self.mixture.log_density(positions)
        each = (np.split(one, steps) for one in (positions, target, mixture))
        self._ahead = list(zip(*each, strict=True))
        if len(self._told) * len(positions) < ENOUGH:
            self._told.append(WeighedProposals(positions, target - mixture))

    def _follow(self, coords: FloatArray) -> None:
        """Weigh by the mixture the walkers that other moves have led away."""
        if self._stood.shape != coords.shape:
            self._stood = np.full_like(coords, np.nan)
            self._log_mixture = np.empty(len(coords))
        moved = (self._stood != coords).any(axis=1)
        if moved.any():
            self._stood[moved] = coords[moved]
            self._log_mixture[moved] = self.mixture.log_density(coords[moved])
