"""Sample a posterior until its diagnostics pass, and how long that may take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.diagnostics import LENGTHS, Diagnostics, autocorrelation_time, diagnose
from hdprog.inference.lost_modes import lost_modes
from hdprog.inference.mixture_proposal import Mixture, fit_mixture
from hdprog.inference.sampler import (
    INDEPENDENT,
    WALKERS,
    EnsembleState,
    RidgePosterior,
    Stretch,
    sample_ensembles,
    spaced_positions,
)
from hdprog.inference.starting_points import StartingPoint
from hdprog.inference.threshold_redraw import ThresholdRedraw
from hdprog.inference.weighed_proposals import WeighedProposals
from hdprog.physics.parameters import FloatArray
from hdprog.progress import Progress, untold

_SLOW = 7.0  # autocorrelation time in steps above which the proposal is fitted anew
_HELPED = 0.8  # of the time before, which a proposal fitted anew must reach to be fitted again
_TAIL_DEGREES = 6.0  # of Student's t where the Gaussians' tails have held walkers up
# Fits after which fewer steps draw from the mixture: what it still misses is walked through.
_FEWER_AFTER, _FEWER = 4, 0.5
_CHAIN_DRAWS_FOR_ONE = 10.0  # that a proposal is fitted to, where independent ones were weighed
_MORE_SEEN = 4  # or chains so many times as long as those that it was fitted to
_FURTHER_FITS = 2  # of the proposal, beyond the bound
# Blocks below which kinks hide between readings: what lies beyond the next reading is a tail of its
# own, which few walkers do not find in the time that their diagnostics ask for, and proposals that
# know the middle best hardly at all.
_FEW_BLOCKS = 40
_WIDE_TEMPERATURE = 2.0


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
    further_steps: int = 0
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


@dataclass(frozen=True)
class _Advanced:
    """A `sampler.Stretch` of all ensembles, with a state for each part that runs by itself."""

    chains: FloatArray
    accepted: float
    states: list[EnsembleState]
    proposed: WeighedProposals | None
    evaluations: int

    @staticmethod
    def of(parts: Sequence[Stretch]) -> _Advanced:
        return _Advanced(
            np.concatenate([one.chains for one in parts]),
            float(np.mean([one.accepted for one in parts])),
            [one.state for one in parts],
            WeighedProposals.together(one.proposed for one in parts),
            sum(one.evaluations for one in parts),
        )

    def then(self, more: _Advanced) -> _Advanced:
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

    def late(self) -> _Advanced:
        """Without the first half of the chains."""
        return replace(self, chains=self.chains[:, self.chains.shape[1] // 2 :])


FULL = SamplingPlan()
QUICK = SamplingPlan(
    required_ess=400.0,
    most_steps=4000,
    further_steps=4000,
    refits=3,
    stored_steps=60,
)


def sample_until_converged(
    posterior: RidgePosterior,
    states: list[EnsembleState],
    plan: SamplingPlan,
    rng: np.random.Generator,
    executor: Executor | None = None,
    progress: Progress = untold,
    modes: Sequence[StartingPoint] = (),
) -> tuple[FloatArray, Diagnostics, dict[str, float], bool]:
    """Warm up, freeze the proposal, sample until all diagnostics pass or the bound is reached.

    Nor may any of the modes that the search had found be lost, where they are given.
    """
    spread = map if executor is None else executor.map
    ensembles, walkers = sum(len(one.position) for one in states), states[0].position.shape[1]
    steps_done = refits = evaluations = 0

    def advance(steps: int, mixture: Mixture | None, temperature: float = 1.0) -> _Advanced:
        nonlocal steps_done, evaluations, states
        many, density = len(states), replace(posterior, temperature=temperature)
        independent = INDEPENDENT if refits < _FEWER_AFTER else _FEWER
        same = ([one] * many for one in (steps, mixture, redraw, independent))
        steps_done += steps
        found = _Advanced.of(list(spread(sample_ensembles, [density] * many, states, *same)))
        states, evaluations = found.states, evaluations + found.evaluations
        return found

    def fitted(seen: list[FloatArray], components: int) -> Mixture:
        # By a worker: this process may be busy with imports for the report.
        return next(iter(spread(fit_mixture, [np.concatenate(seen)], [components], rng.spawn(1))))

    def fitted_anew(seen: list[FloatArray]) -> Mixture:
        again = fitted([*seen, *regained], plan.components[-1] + 4 * refits + 2)
        return replace(again, degrees=_TAIL_DEGREES)

    mixture: Mixture | None = None
    redraw = ThresholdRedraw(posterior.likelihood) if posterior.likelihood.ridge else None
    late: list[FloatArray] = []
    regained: list[FloatArray] = []
    cooling = plan.temperatures[-len(plan.warm_up_steps) :]
    parts = zip(plan.warm_up_steps, cooling, plan.components, strict=False)
    for steps, temperature, components in parts:
        found = advance(steps, mixture, temperature).late()
        # The parts before were wider: the proposal keeps what they saw.
        late = [*late[-2:], found.to_fit(plan, rng)]
        mixture = fitted(late, components)
    if redraw is not None and not redraw.concerns(np.concatenate(late)).any():
        redraw = None  # of no use to this record
    warm_up = steps_done
    run = advance(plan.first_steps, mixture)
    slowest, fitted_to = math.inf, plan.first_steps
    bound, fits = plan.most_steps, plan.refits
    while True:
        tau = float(autocorrelation_time(run.chains).max())
        total = run.chains.shape[1]
        worth_it = tau < _HELPED * slowest or total >= _MORE_SEEN * fitted_to
        if tau > _SLOW and refits < fits and worth_it:
            # The proposal misses part of the posterior: what was seen so far becomes warm-up.
            slowest, fitted_to = tau, total
            seen = [run.to_fit(plan, rng)]
            if plan.wide_steps:
                wide_steps, here = (refits + 1) * plan.wide_steps, states
                wide = advance(wide_steps, mixture, _WIDE_TEMPERATURE)
                states = [
                    replace(one, position=was.position)
                    for one, was in zip(states, here, strict=True)
                ]
                seen.append(spaced_positions(wide.chains[:, wide_steps // 4 :], plan.fitted_draws))
            mixture = fitted_anew(seen)
            warm_up, refits = steps_done, refits + 1
            run = advance(plan.first_steps * refits, mixture)
            continue
        wanted = max(plan.first_steps, math.ceil(plan.lengths * tau))
        progress("sampling", min(total, wanted), wanted)
        if total >= wanted or steps_done >= bound:
            chains = _unconstrained(posterior, run.chains[:, :: max(1, int(tau / 2))])
            diagnostics = diagnose(chains)
            converged = total >= wanted and diagnostics.passes(plan.required_ess)
            lost = None
            if converged and modes and mixture is not None:
                state = states[0].random_state
                lost = lost_modes(posterior, mixture, run.chains, modes, state)
                converged = lost is None
            if lost is not None and steps_done < plan.most_steps + plan.further_steps:
                # All before was without them: walkers first find their way back.
                regained.append(lost)
                mixture = fitted_anew([run.to_fit(plan, rng)])
                slowest, fitted_to, refits = math.inf, plan.first_steps, refits + 1
                advance(plan.first_steps, mixture)
                warm_up = steps_done
                run = advance(plan.first_steps * refits, mixture)
                continue
            if converged or steps_done >= plan.most_steps + plan.further_steps:
                break
            if steps_done >= bound:
                bound, fits = bound + plan.further_steps, fits + _FURTHER_FITS
                slowest = math.inf
                continue
            wanted = int(1.5 * total)
        # Twice as long at most before the next look: where sampling is slow, more is learnt soon.
        further = min(wanted - total, total) if refits < fits else wanted - total
        run = run.then(advance(min(further, bound - steps_done), mixture))
    sampling = {
        "effective_blocks": posterior.likelihood.block_degrees + 1.0,
        "ensembles": float(ensembles),
        "walkers": float(walkers),
        "warm_up_steps": float(warm_up),
        "steps": float(total),
        "autocorrelation_time": tau,
        "acceptance": run.accepted,
        "evaluations": float(evaluations),
    }
    if lost is not None:
        sampling["lost_mode"] = 1.0
    return chains, diagnostics, sampling, converged


def _unconstrained(posterior: RidgePosterior, ridge: FloatArray) -> FloatArray:
    flat = posterior.points(ridge.reshape(-1, ridge.shape[-1]))
    return flat.reshape(ridge.shape)
