"""Ensembles and the proposal that they share, fitted anew to what they and it have seen."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.mixture_proposal import Mixture, fit_mixture
from hdprog.inference.sampler import (
    INDEPENDENT,
    EnsembleState,
    RidgePosterior,
    Stretch,
    sample_ensembles,
    spaced_positions,
)
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.inference.threshold_redraw import ThresholdRedraw
from hdprog.inference.weighed_proposals import WeighedProposals
from hdprog.physics.parameters import FloatArray

_TAIL_DEGREES = 6.0  # of Student's t where the Gaussians' tails have held walkers up
# Fits after which fewer steps draw from the mixture: what it still misses is walked through.
_FEWER_AFTER, _FEWER = 4, 0.5
_CHAIN_DRAWS_FOR_ONE = 10.0  # that a proposal is fitted to, where independent ones were weighed
_WIDE_TEMPERATURE = 2.0


@dataclass(frozen=True)
class Advanced:
    """A `sampler.Stretch` of all ensembles, with a state for each part that runs by itself."""

    chains: FloatArray
    accepted: float
    states: list[EnsembleState]
    proposed: WeighedProposals | None
    evaluations: int

    @staticmethod
    def of(parts: Sequence[Stretch]) -> Advanced:
        """All ensembles of parts that were as long."""
        return Advanced(
            np.concatenate([one.chains for one in parts]),
            float(np.mean([one.accepted for one in parts])),
            [one.state for one in parts],
            WeighedProposals.together(one.proposed for one in parts),
            sum(one.evaluations for one in parts),
        )

    def then(self, more: Advanced) -> Advanced:
        """Together with the next stretch, by the same proposal."""
        chains = np.concatenate([self.chains, more.chains], axis=1)
        proposed = WeighedProposals.together([self.proposed, more.proposed])
        # Acceptance stays that of the longer first stretch: the last one may be a few steps.
        return replace(more, chains=chains, proposed=proposed, accepted=self.accepted)

    def to_fit(self, plan: SamplingPlan, rng: np.random.Generator) -> FloatArray:
        """Positions to fit a proposal to."""
        if self.proposed is None or not plan.fitted_proposals:
            return spaced_positions(self.chains, plan.fitted_draws)
        few = int(self.chains[..., 0].size / _CHAIN_DRAWS_FOR_ONE)
        of_chains = spaced_positions(self.chains, min(plan.fitted_draws, few))
        return np.concatenate([of_chains, self.proposed.resampled(plan.fitted_proposals, rng)])

    def late(self) -> Advanced:
        """Without the first half of the chains."""
        return replace(self, chains=self.chains[:, self.chains.shape[1] // 2 :])


class AdaptingEnsembles:
    """Walkers of one posterior on their way, all parts by the same frozen proposal.

    Attributes
    ----------
    posterior : that they sample
    states : where they stand, one a part
    mixture : their proposal; None before the first fit
    run : what they sampled since that was fitted
    steps, evaluations : done so far, of each ensemble and in all
    warm_up : steps before `run`
    refits : of the proposal behind the warm-up
    """

    def __init__(
        self,
        posterior: RidgePosterior,
        states: list[EnsembleState],
        plan: SamplingPlan,
        rng: np.random.Generator,
        executor: Executor | None,
    ) -> None:
        self.posterior, self.states = posterior, states
        self.mixture: Mixture | None = None
        self.run: Advanced
        self.steps = self.evaluations = self.refits = 0
        self._plan, self._rng = plan, rng
        self._spread = map if executor is None else executor.map
        self._redraw = ThresholdRedraw(posterior.likelihood) if posterior.likelihood.ridge else None
        self._regained: list[FloatArray] = []
        self._warm_up()
        self._begin_run(plan.first_steps)

    def extend(self, steps: int) -> None:
        """Make the run longer by so many steps."""
        self.run = self.run.then(self._advance(steps))

    def fit_again(self) -> None:
        """Fit the proposal to the run, which becomes warm-up."""
        seen = [self.run.to_fit(self._plan, self._rng)]
        if self._plan.wide_steps:
            seen.append(self._seen_wide((self.refits + 1) * self._plan.wide_steps))
        self._fit_again(seen)
        self._begin_run(self._plan.first_steps * self.refits)

    def find_back(self, lost: FloatArray) -> None:
        """Fit the proposal to draws (draws, dimensions) of what was lost, too.

        All before was without them: walkers first find their way back.
        """
        self._regained.append(lost)
        self._fit_again([self.run.to_fit(self._plan, self._rng)])
        self._advance(self._plan.first_steps)
        self._begin_run(self._plan.first_steps * self.refits)

    def _warm_up(self) -> None:
        plan, late = self._plan, list[FloatArray]()
        cooling = plan.temperatures[-len(plan.warm_up_steps) :]
        parts = zip(plan.warm_up_steps, cooling, plan.components, strict=False)
        for steps, temperature, components in parts:
            found = self._advance(steps, temperature).late()
            # The parts before were wider: the proposal keeps what they saw.
            late = [*late[-2:], found.to_fit(plan, self._rng)]
            self.mixture = self._fitted(late, components)
        if self._redraw is not None and not self._redraw.concerns(np.concatenate(late)).any():
            self._redraw = None  # of no use to this record

    def _begin_run(self, steps: int) -> None:
        self.warm_up = self.steps
        self.run = self._advance(steps)

    def _advance(self, steps: int, temperature: float = 1.0) -> Advanced:
        """Go on; the temperature is in parts of the posterior's own."""
        temperature *= self.posterior.temperature
        many, density = len(self.states), replace(self.posterior, temperature=temperature)
        independent = INDEPENDENT if self.refits < _FEWER_AFTER else _FEWER
        same = ([one] * many for one in (steps, self.mixture, self._redraw, independent))
        parts = self._spread(sample_ensembles, [density] * many, self.states, *same)
        found = Advanced.of(list(parts))
        self.steps += steps
        self.states, self.evaluations = found.states, self.evaluations + found.evaluations
        return found

    def _seen_wide(self, steps: int) -> FloatArray:
        """Positions of walkers that go so many steps beside the run."""
        here = self.states
        wide = self._advance(steps, _WIDE_TEMPERATURE)
        self.states = [
            replace(one, position=was.position) for one, was in zip(self.states, here, strict=True)
        ]
        return spaced_positions(wide.chains[:, steps // 4 :], self._plan.fitted_draws)

    def _fit_again(self, seen: list[FloatArray]) -> None:
        components = self._plan.components[-1] + 4 * self.refits + 2
        again = self._fitted([*seen, *self._regained], components)
        self.mixture, self.refits = replace(again, degrees=_TAIL_DEGREES), self.refits + 1

    def _fitted(self, seen: list[FloatArray], components: int) -> Mixture:
        # By a worker: this process may be busy with imports for the report.
        positions, rngs = [np.concatenate(seen)], self._rng.spawn(1)
        return next(iter(self._spread(fit_mixture, positions, [components], rngs)))
