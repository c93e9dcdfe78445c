"""Sample a posterior until its diagnostics pass, or a bound is reached."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor

import numpy as np

from hdprog.inference.adapting_ensembles import AdaptingEnsembles
from hdprog.inference.diagnostics import Diagnostics, autocorrelation_time, diagnose
from hdprog.inference.lost_modes import lost_modes
from hdprog.inference.sampler import EnsembleState, RidgePosterior
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.parameters import FloatArray
from hdprog.progress import Progress, untold

_SLOW = 7.0  # autocorrelation time in steps above which the proposal is fitted anew
_HELPED = 0.8  # of the time before, which a proposal fitted anew must reach to be fitted again
_MORE_SEEN = 4  # or chains so many times as long as those that it was fitted to
_FURTHER_FITS = 2  # of the proposal, beyond the bound


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
    ensembles = AdaptingEnsembles(posterior, states, plan, rng, executor)
    slowest, fitted_to = math.inf, plan.first_steps
    bound, fits = plan.most_steps, plan.refits
    last = plan.most_steps + plan.further_steps
    while True:
        sampled = ensembles.run.chains
        tau, total = float(autocorrelation_time(sampled).max()), sampled.shape[1]
        worth_it = tau < _HELPED * slowest or total >= _MORE_SEEN * fitted_to
        if tau > _SLOW and ensembles.refits < fits and worth_it:
            # The proposal misses part of the posterior.
            slowest, fitted_to = tau, total
            ensembles.fit_again()
            continue
        wanted = max(plan.first_steps, math.ceil(plan.lengths * tau))
        progress("sampling", min(total, wanted), wanted)
        if total >= wanted or ensembles.steps >= bound:
            chains = _unconstrained(posterior, sampled[:, :: max(1, int(tau / 2))])
            diagnostics = diagnose(chains)
            settled = total >= wanted and diagnostics.passes(plan.required_ess)
            lost = _lost(ensembles, modes) if settled else None
            if lost is not None and ensembles.steps < last:
                slowest, fitted_to = math.inf, plan.first_steps
                ensembles.find_back(lost)
                continue
            converged = settled and lost is None
            if converged or ensembles.steps >= last:
                break
            if ensembles.steps >= bound:
                bound, fits, slowest = last, fits + _FURTHER_FITS, math.inf
                continue
            wanted = int(1.5 * total)
        # Twice as long at most before the next look: where sampling is slow, more is learnt soon.
        further = min(wanted - total, total) if ensembles.refits < fits else wanted - total
        ensembles.extend(min(further, bound - ensembles.steps))
    number, walkers = sampled.shape[0], sampled.shape[2]
    sampling = {
        "effective_blocks": posterior.likelihood.block_degrees + 1.0,
        "ensembles": float(number),
        "walkers": float(walkers),
        "warm_up_steps": float(ensembles.warm_up),
        "steps": float(total),
        "autocorrelation_time": tau,
        "acceptance": ensembles.run.accepted,
        "evaluations": float(ensembles.evaluations),
    }
    if lost is not None:
        sampling["lost_mode"] = 1.0
    return chains, diagnostics, sampling, converged


def _lost(ensembles: AdaptingEnsembles, modes: Sequence[StartingPoint]) -> FloatArray | None:
    """Draws of modes that the chains have lost; None where there are none."""
    if not modes or ensembles.mixture is None:
        return None
    state = ensembles.states[0].random_state
    return lost_modes(ensembles.posterior, ensembles.mixture, ensembles.run.chains, modes, state)


def _unconstrained(posterior: RidgePosterior, ridge: FloatArray) -> FloatArray:
    flat = posterior.points(ridge.reshape(-1, ridge.shape[-1]))
    return flat.reshape(ridge.shape)
