"""Fit one loop: prepare it, find the modes, sample until converged."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.diagnostics import LENGTHS, Diagnostics, autocorrelation_time, diagnose
from hdprog.inference.effect_starts import effect_starts, require, search_widely
from hdprog.inference.effective_blocks import effective_degrees
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.linearised_effects import PARETO_K_LIMIT, LinearisedEffects
from hdprog.inference.mixture_proposal import GaussianMixture, fit_mixture
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, prepare, settle_noise
from hdprog.inference.priors import Prior
from hdprog.inference.sampler import (
    ENSEMBLES,
    WALKERS,
    EnsembleState,
    RidgePosterior,
    initial_states,
    sample_ensembles,
)
from hdprog.inference.starting_points import StartingPoint, describe
from hdprog.inference.threshold_redraw import ThresholdRedraw
from hdprog.physics.effects.base import Effect
from hdprog.physics.parameters import FloatArray

Progress = Callable[[str, int, int], None]
_SLOW = 9.0  # autocorrelation time in steps above which the proposal is fitted anew
_HELPED = 0.8  # of the time before, which a proposal fitted anew must reach to be fitted again
_MORE_SEEN = 4  # or chains so many times as long as those that it was fitted to
_MIXTURE_DRAWS = 6000


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
    refits : times that the proposal is fitted anew where sampling stays slow
    stored_steps : steps kept for each walker after thinning
    """

    required_ess: float = 1000.0
    lengths: float = LENGTHS
    warm_up_steps: tuple[int, ...] = (100, 40, 80)
    temperatures: tuple[float, ...] = (4.0, 2.0, 1.0)
    components: tuple[int, ...] = (3, 6, 10)
    first_steps: int = 200
    most_steps: int = 10_000
    refits: int = 6
    stored_steps: int = 125


FULL = SamplingPlan()
QUICK = SamplingPlan(
    required_ess=400.0, first_steps=150, most_steps=4000, refits=3, stored_steps=60
)


def fit_loop(
    loop: Loop,
    drive: Drive,
    rng: np.random.Generator,
    *,
    prior: Prior | None = None,
    effects: tuple[Effect, ...] = (),
    plan: SamplingPlan = FULL,
    parts: int = 1,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Posterior:
    """Posterior of the eight parameters from one loop.

    Parameters
    ----------
    loop : the record
    drive : its declared constants, prior and noise
    rng : the only source of randomness
    prior : overrides the drive's own, e.g. to share one over the tests of a drive
    effects : beside the drive model, fitted with it
    plan : how long to sample
    parts : into how many the ensembles are divided; the draws depend on it
    executor : runs the parts side by side; in this process if None
    progress : called with stage, effective lengths done and wanted

    Returns
    -------
    Posterior, marked where it did not converge

    Raises
    ------
    BadInputError
        if the drive names a prior that does not exist, or the record lacks what an effect needs
    """
    prepared = prepare(loop, drive, rng, prior=prior)
    for effect in effects:
        require(effect, prepared.likelihood.reduced.course, loop.source)
    likelihood, starts = prepared.likelihood, prepared.starts
    for effect in effects:
        likelihood = replace(likelihood, effects=(*likelihood.effects, effect))
        starts = search_widely(likelihood, effect_starts(likelihood, starts), rng)
    likelihood, starts = settle_noise(likelihood, starts, rng)
    return sample_posterior(
        prepared,
        likelihood,
        starts,
        rng,
        plan=plan,
        parts=parts,
        executor=executor,
        progress=progress,
    )


def sample_posterior(
    prepared: Prepared,
    likelihood: LoopLikelihood,
    starts: list[StartingPoint],
    rng: np.random.Generator,
    *,
    plan: SamplingPlan = FULL,
    parts: int = 1,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Posterior:
    """Posterior of a prepared record under one model.

    Parameters
    ----------
    prepared : the record
    likelihood : with its noise and effects
    starts : modes of it, best first
    parts : into how many the ensembles are divided; the draws depend on it
    rng, plan, executor, progress : as in `fit_loop`
    """
    degrees = effective_degrees(likelihood, starts[0])
    if degrees < likelihood.degrees:
        likelihood = replace(likelihood, effective=degrees)
        starts = [describe(likelihood, start.point) for start in starts]
    linearised = LinearisedEffects.about(likelihood, starts[0]) if likelihood.effects else None
    sampled = likelihood if linearised is None else linearised.sampled
    posterior = RidgePosterior(sampled)
    modes = [_without_effects(start) for start in starts]
    states = initial_states(posterior, modes, rng, parts)
    chains, diagnostics, sampling, converged = sample_until_converged(
        posterior, states, plan, rng, executor, progress
    )
    stored = chains[:, :: -(-chains.shape[1] // plan.stored_steps)]
    flat = stored.reshape(-1, sampled.size)
    offset, scale = sampled.nuisances(flat, rng)
    if linearised is not None:
        flat = linearised.complete(flat, offset, scale, rng)
        sampling["pareto_k"] = linearised.pareto_k(flat, offset, scale)
        stored = flat.reshape(*stored.shape[:3], likelihood.size)
    warnings = list(prepared.warnings)
    if likelihood.effective is not None:
        warnings.append(
            f"What the fit leaves hangs together beyond its noise model: its {likelihood.blocks} "
            f"blocks count as {likelihood.degrees + 1:.0f} independent ones, and intervals are "
            f"{likelihood.widening:.1f} times as wide as if all were. An error of the model that "
            "repeats is not in them."
        )
    if not converged:
        warnings.insert(
            0,
            f"This fit did not converge within {sampling['steps']:.0f} steps (largest R-hat "
            f"{diagnostics.rhat.max():.3f}, fewest effective draws "
            f"{min(diagnostics.ess_bulk.min(), diagnostics.ess_tail.min()):.0f}): its numbers "
            "are not to be relied on.",
        )
    if likelihood.effects or likelihood.noise.term is not None:
        warnings.append(_figures_leave_out(likelihood))
    if sampling.get("pareto_k", 0.0) > PARETO_K_LIMIT:
        warnings.append(
            "The effects' parameters are drawn from a model that is linear in them, and this record"
            f" bends it (Pareto k {sampling['pareto_k']:.1f}, above {PARETO_K_LIMIT}): their "
            "intervals are rough; the drive's parameters are less touched."
        )
    return Posterior(
        loop=prepared.loop,
        drive=prepared.drive,
        prior=likelihood.prior,
        operation=prepared.operation,
        likelihood=likelihood,
        chains=stored,
        offset=offset.reshape(stored.shape[:3]),
        noise_scale=scale.reshape(stored.shape[:3]) / likelihood.widening,
        diagnostics=diagnostics,
        converged=converged,
        best=starts[0].point,
        turning_points=prepared.turning_points,
        kept=prepared.kept,
        record_course=prepared.record_course,
        noise_floor=prepared.noise_floor,
        sampling=sampling,
        warnings=tuple(warnings),
    )


def _figures_leave_out(likelihood: LoopLikelihood) -> str:
    names = [effect.id.replace("_", " ") for effect in likelihood.effects]
    if (term := likelihood.noise.term) is not None:
        names.append(f"the empirical curve over {term.coordinate.replace('_', ' ')}")
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    said = (
        "The figures of merit are those of the eight parameters: what "
        f"{listed} add{'s' if len(names) == 1 else ''} to the loop is not in them."
    )
    if any(effect.lasting and effect.static for effect in likelihood.effects):
        said += " Width, loss and lost motion with what is lasting are given beside them."
    return said


def _without_effects(start: StartingPoint) -> StartingPoint:
    """The mode in the nine coordinates that are sampled; the effects are integrated out."""
    return replace(
        start, point=start.point[: COUNT + 1], covariance=start.covariance[: COUNT + 1, : COUNT + 1]
    )


def sample_until_converged(
    posterior: RidgePosterior,
    states: list[EnsembleState],
    plan: SamplingPlan,
    rng: np.random.Generator,
    executor: Executor | None,
    progress: Progress | None,
) -> tuple[FloatArray, Diagnostics, dict[str, float], bool]:
    """Warm up, freeze the proposal, sample until all diagnostics pass or the bound is reached."""
    spread = map if executor is None else executor.map
    steps_done = 0

    def advance(
        steps: int, mixture: GaussianMixture | None, temperature: float = 1.0
    ) -> tuple[FloatArray, float, list[EnsembleState]]:
        nonlocal steps_done
        many, density = len(states), replace(posterior, temperature=temperature)
        same = ([one] * many for one in (steps, mixture, redraw))
        results = list(spread(sample_ensembles, [density] * many, states, *same))
        steps_done += steps
        chains = np.concatenate([chains for chains, _, _ in results])
        accepted = float(np.mean([share for _, share, _ in results]))
        return chains, accepted, [state for _, _, state in results]

    mixture: GaussianMixture | None = None
    redraw = ThresholdRedraw(posterior.likelihood) if posterior.likelihood.ridge else None
    late: list[FloatArray] = []
    cooling = plan.temperatures[-len(plan.warm_up_steps) :]
    parts = zip(plan.warm_up_steps, cooling, plan.components, strict=False)
    for steps, temperature, components in parts:
        chains, _, states = advance(steps, mixture, temperature)
        # The part before was wider: the proposal keeps what it saw.
        late = [*late[-1:], _some(chains[:, steps // 2 :])]
        mixture = fit_mixture(np.concatenate(late), components, rng)
    if redraw is not None and not redraw.concerns(np.concatenate(late)).any():
        redraw = None  # of no use to this record
    warm_up = steps_done
    ridge, accepted, states = advance(plan.first_steps, mixture)
    refits, slowest, fitted_to = 0, math.inf, plan.first_steps
    while True:
        tau = float(autocorrelation_time(ridge).max())
        total = ridge.shape[1]
        worth_it = tau < _HELPED * slowest or total >= _MORE_SEEN * fitted_to
        if tau > _SLOW and refits < plan.refits and worth_it:
            # The proposal misses part of the posterior: what was seen so far becomes warm-up.
            slowest, fitted_to = tau, total
            mixture = fit_mixture(_some(ridge), plan.components[-1] + 4 * refits + 2, rng)
            warm_up, refits = steps_done, refits + 1
            ridge, accepted, states = advance(plan.first_steps * refits, mixture)
            continue
        wanted = max(plan.first_steps, math.ceil(plan.lengths * tau))
        if progress is not None:
            progress("sampling", min(total, wanted), wanted)
        if total >= wanted or steps_done >= plan.most_steps:
            chains = _unconstrained(posterior, ridge[:, :: max(1, int(tau / 2))])
            diagnostics = diagnose(chains)
            converged = total >= wanted and diagnostics.passes(plan.required_ess)
            if converged or steps_done >= plan.most_steps:
                break
            wanted = int(1.5 * total)
        # Twice as long at most before the next look: where sampling is slow, more is learnt soon.
        further = min(wanted - total, total) if refits < plan.refits else wanted - total
        more, _, states = advance(min(further, plan.most_steps - steps_done), mixture)
        ridge = np.concatenate([ridge, more], axis=1)
    sampling = {
        "effective_blocks": posterior.likelihood.degrees + 1.0,
        "ensembles": float(ENSEMBLES),
        "walkers": float(WALKERS),
        "warm_up_steps": float(warm_up),
        "steps": float(total),
        "autocorrelation_time": tau,
        "acceptance": accepted,
        "evaluations": float(steps_done * ENSEMBLES * WALKERS),
    }
    return chains, diagnostics, sampling, converged


def _some(ridge: FloatArray) -> FloatArray:
    """At most a few thousand positions (positions, 9), evenly spaced in all chains."""
    pooled = ridge.reshape(-1, ridge.shape[-1])
    chosen = np.linspace(0, len(pooled) - 1, min(len(pooled), _MIXTURE_DRAWS)).astype(int)
    return np.asarray(pooled[chosen])


def _unconstrained(posterior: RidgePosterior, ridge: FloatArray) -> FloatArray:
    flat = posterior.points(ridge.reshape(-1, ridge.shape[-1]))
    return flat.reshape(ridge.shape)
