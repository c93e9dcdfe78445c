"""An emcee move on several independent ensembles at once, so that one call evaluates them all.

R-hat compares ensembles that know nothing of each other. Run one after the other they call the
density with a dozen positions a time, and most of its cost is that of the call.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from emcee.moves import Move
from emcee.moves.red_blue import RedBlueMove
from emcee.state import State


class SideBySide(Move):  # type: ignore[misc]  # emcee has no types
    """Apply a red-blue move to each of several ensembles; walkers of one never see another's.

    Parameters
    ----------
    inner : proposes for one half of an ensemble from the other half
    ensembles : how many; walkers are in the order of their ensembles, equally many in each
    """

    def __init__(self, inner: RedBlueMove, ensembles: int) -> None:
        self.inner = inner
        self.ensembles = ensembles

    def propose(self, model: Any, state: State) -> tuple[State, np.ndarray]:
        """Take one step of every ensemble; see `emcee.moves.RedBlueMove.propose`."""
        random, coords = model.random, state.coords
        per = len(coords) // self.ensembles
        self.inner.setup(coords)
        accepted = np.zeros(len(coords), dtype=bool)
        first = np.arange(self.ensembles)[:, None] * per
        shuffled = first + np.argsort(random.random_sample((self.ensembles, per)), axis=1)
        halves = (shuffled[:, : per // 2], shuffled[:, per // 2 :])
        for moving, resting in (halves, halves[::-1]):
            proposed = [
                self.inner.get_proposal(coords[mine], [coords[others]], random)
                for mine, others in zip(moving, resting, strict=True)
            ]
            where = moving.ravel()
            position = np.concatenate([one for one, _ in proposed])
            factor = np.concatenate([one for _, one in proposed])
            # Not by emcee's own way to it, which looks at every number by itself.
            log_prob = model.log_prob_fn(position)
            gain = factor + log_prob - state.log_prob[where]
            taken = gain > np.log(random.random_sample(where.size))
            coords[where[taken]] = position[taken]
            state.log_prob[where[taken]] = log_prob[taken]
            accepted[where[taken]] = True
        return state, accepted
