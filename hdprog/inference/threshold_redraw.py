"""Redraws of the teeth's threshold from its prior, for records that end about there.

Where T_T lies beyond the largest torque the likelihood does not know it: the posterior has a shelf
as wide as the prior, with little mass, that begins at the narrow main mode. Steps that suit the
mode hardly ever find it, and a proposal fitted to their draws does not reach it. A draw of the
prior with all other parameters as they are lands on the shelf or near its beginning, where the
likelihood is the same, and is accepted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained
from hdprog.physics.parameters import BY_NAME, NAMES, FloatArray

_T_T = NAMES.index("T_T")
_FROM = 0.85  # of the largest torque: readings above it tell little of a kink among them
_RULED_OUT = 1e-300  # share of the prior beyond the record of which nothing can be drawn


@dataclass(frozen=True)
class ThresholdRedraw:
    """Proposal function for `emcee.moves.MHMove` over the positions of a `RidgePosterior`.

    A walker whose threshold lies above `lowest` gets another from the part of the prior above it;
    all others are turned down where they stand. Both ways are equally likely by the prior, so that
    the posterior stays as it is.

    Attributes
    ----------
    likelihood : of the loop
    """

    likelihood: LoopLikelihood

    @property
    def lowest(self) -> float:
        """Coordinate of the threshold above which it is redrawn."""
        _, scale, largest = self.likelihood.ridge_frame
        return float(BY_NAME["T_T"].to_coordinate(np.asarray(_FROM * largest), scale))

    def concerns(self, position: FloatArray) -> NDArray[np.bool_]:
        """(walkers,) whether positions (walkers, dimensions) are those that get a new threshold."""
        return np.asarray(position[:, _T_T] > self.lowest)

    def __call__(
        self, position: FloatArray, random: np.random.RandomState
    ) -> tuple[FloatArray, FloatArray]:
        """New positions (walkers, dimensions) and log q(old)/q(new), (walkers,)."""
        proposed, factor = position.copy(), np.full(len(position), -np.inf)
        mean, sd = self.likelihood.prior.mean[_T_T], self.likelihood.prior.sd[_T_T]
        share = ndtr((mean - self.lowest) / sd)
        moved = self.concerns(position) & (share > _RULED_OUT)
        ridge = self.likelihood.ridge_frame
        old, old_jacobian = to_unconstrained(position[moved, :COUNT], *ridge)
        above = 1.0 - random.random_sample(len(old))
        new = old.copy()
        new[:, _T_T] = mean - sd * ndtri(above * share)
        proposed[moved, :COUNT] = from_unconstrained(new, *ridge)
        new_jacobian = to_unconstrained(proposed[moved, :COUNT], *ridge)[1]
        prior = self.likelihood.prior.log_density
        factor[moved] = prior(old) - prior(new) + old_jacobian - new_jacobian
        return proposed, factor
