"""How long a posterior is sampled, and how its proposal is found."""

from __future__ import annotations

from dataclasses import dataclass, replace

from hdprog.inference.diagnostics import LENGTHS
from hdprog.inference.sampler import WALKERS

# Blocks below which kinks hide between readings: what lies beyond the next reading is a tail of its
# own, which few walkers do not find in the time that their diagnostics ask for, and proposals that
# know the middle best hardly at all.
_FEW_BLOCKS = 40


@dataclass(frozen=True)
class SamplingPlan:
    """How long to sample.

    Attributes
    ----------
    required_ess : bulk and tail effective draws of every parameter
    lengths : of the chains, in autocorrelation times
    warm_up_steps : lengths of the warm-up's parts; behind each the proposal is fitted anew
    temperatures : of the likelihood in each of them, the last for the last: walkers begin wide, so
        that shelves and modes beside the main one are seen and proposed
    components : Gaussians of the proposal behind each part
    first_steps : steps before the first look
    most_steps : bound, warm-up included; past it the posterior is marked as not converged
    further_steps : where the bound is reached without convergence, that many more behind fits of
        the proposal to all that was seen
    refits : times that the proposal is fitted anew where sampling stays slow
    wide_steps : at twice the temperature before the first of these fits, and as many more before
        each later one: the proposal is fitted to what is seen there, too
    fitted_draws : to which the proposal is fitted, at each temperature
    fitted_proposals : at most as many of the independent proposals, weighed, beside fewer draws
    walkers : of each ensemble
    stored_steps : steps kept for each walker after thinning
    """

    required_ess: float = 1000.0
    lengths: float = LENGTHS
    warm_up_steps: tuple[int, ...] = (100, 40, 60, 100)
    temperatures: tuple[float, ...] = (4.0, 2.0, 1.0, 1.0)
    components: tuple[int, ...] = (3, 5, 6, 8)
    first_steps: int = 200
    most_steps: int = 10_000
    further_steps: int = 6_000
    refits: int = 6
    wide_steps: int = 0
    fitted_draws: int = 6000
    fitted_proposals: int = 6000
    walkers: int = WALKERS
    stored_steps: int = 125

    def suited_to(self, blocks: int) -> SamplingPlan:
        """The plan for a record of so many blocks: few are cheap, and want a longer search."""
        if blocks >= _FEW_BLOCKS:
            return self
        return replace(
            self,
            wide_steps=self.first_steps,
            fitted_draws=10_000,
            fitted_proposals=0,
            walkers=4 * self.walkers,
            stored_steps=max(1, self.stored_steps // 4),
        )


FULL = SamplingPlan()
QUICK = SamplingPlan(
    required_ess=400.0,
    most_steps=4000,
    further_steps=4000,
    refits=3,
    stored_steps=60,
)
