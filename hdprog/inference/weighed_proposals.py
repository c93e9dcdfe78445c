"""What independent proposals tell of a posterior, whether they were accepted or not.

Chains hold those that were accepted, and hold on to them; that a proposal was turned down tells as
much. Weighed by importance, all of them together are worth more draws than the chains are.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hdprog.physics.parameters import FloatArray

ENOUGH = 20_000  # proposals of one mixture: what more of them tell no mixture follows
_COPIES = 2.0  # of an effective draw: fewer leave out what is known, more cost time


@dataclass(frozen=True)
class WeighedProposals:
    """Draws of a mixture with what they weigh.

    Attributes
    ----------
    positions : (proposals, dimensions)
    log_weight : (proposals,) log density of the target over that of the mixture
    """

    positions: FloatArray
    log_weight: FloatArray

    @staticmethod
    def together(each: Iterable[WeighedProposals | None]) -> WeighedProposals | None:
        """Enough of those of one mixture, wherever drawn and whenever; None where none were."""
        told: list[WeighedProposals] = []
        count = 0
        for one in each:
            if one is not None and count < ENOUGH:
                told.append(one)
                count += len(one.positions)
        if not told:
            return None
        positions = np.concatenate([one.positions for one in told])
        return WeighedProposals(positions, np.concatenate([one.log_weight for one in told]))

    def resampled(self, most: int, rng: np.random.Generator) -> FloatArray:
        """About as many equally likely positions as they are worth, at most so many.

        Few proposals outweigh all others where a mixture fits badly: weights are cut off at √n
        times their mean (Ionides, J. Comp. Graph. Stat. 17, 2008).
        """
        largest = self.log_weight.max()
        if not np.isfinite(largest):
            return self.positions[:0]
        weight = np.exp(self.log_weight - largest)
        weight = np.minimum(weight, np.sqrt(weight.size) * weight.mean())
        passed = np.cumsum(weight)
        count = int(min(most, _COPIES * passed[-1] ** 2 / np.sum(weight**2)))
        levels = passed[-1] * (np.arange(count) + rng.uniform()) / count
        return np.asarray(self.positions[np.searchsorted(passed, levels)])
