"""Fit one loop: prepare it, find the modes, sample until converged."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.explanation import spoken_effect
from hdprog.inference.diagnostics import Diagnostics
from hdprog.inference.effect_starts import effect_starts, require, search_widely
from hdprog.inference.effective_blocks import effective_degrees
from hdprog.inference.least_squares import kept_to_readings
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.linearised_effects import PARETO_K_LIMIT, EffectDraws, LinearisedEffects
from hdprog.inference.measured_noise import local_slope
from hdprog.inference.noise_of_readings import with_noise_of_readings
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, prepare, settle_noise
from hdprog.inference.priors import Prior
from hdprog.inference.sampler import RidgePosterior, initial_states, worth_walkers
from hdprog.inference.sampling_plan import FULL, SamplingPlan
from hdprog.inference.starting_points import StartingPoint, describe
from hdprog.inference.until_converged import sample_until_converged
from hdprog.inference.within_blocks import WithinBlocks
from hdprog.physics.effects.base import Effect
from hdprog.physics.parameters import FloatArray
from hdprog.progress import Progress, untold

_WIDER = 1.5  # temperature of the likelihood where draws at one stand for nothing
_WITH_EFFECTS = 60  # steps kept where effects are drawn beside: a draw costs ten evaluations


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
    progress: Progress = untold,
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
    to_readings: bool = True,
    executor: Executor | None = None,
    progress: Progress = untold,
) -> Posterior:
    """Posterior of a prepared record under one model.

    Parameters
    ----------
    prepared : the record
    likelihood : with its noise and effects
    starts : modes of it, best first
    parts : into how many the ensembles are divided; the draws depend on it
    to_readings : take the noise that readings tell, see `noise_of_readings`, and keep least squares
        where it leads the fit away, see `least_squares`
    rng, plan, executor, progress : as in `fit_loop`
    """
    told: WithinBlocks | None = None
    if to_readings:
        likelihood, starts, told = with_noise_of_readings(prepared, likelihood, starts)
        beside = starts[0].point[COUNT + 1 :]
        known = [np.concatenate([start.point, beside]) for start in prepared.starts]
        likelihood, starts = kept_to_readings(likelihood, starts, known)
    if likelihood.least_squares is None:
        likelihood, starts = _weighed(prepared, likelihood, starts, told)
    linearised = LinearisedEffects.about(likelihood, starts[0]) if likelihood.effects else None
    plan = plan.suited_to(likelihood.blocks)

    def sample(beside: LinearisedEffects | None, temperature: float = 1.0) -> _Sampled:
        model = (likelihood, beside, temperature)
        return _sample(*model, starts, rng, plan, parts, executor, progress)

    found = sample(linearised)
    if (drawn := found.drawn) is not None and not found.converged:
        # Wider draws reach tails that a linear model of the effects misses. All coordinates at once
        # cost most and lean on nothing, where they settle.
        wider = sample(linearised, _WIDER)
        if wider.converged:
            found = wider
        elif not drawn.usable:
            exactly = sample(None)
            found = exactly if exactly.converged else found
    drawn, sampling, diagnostics = found.drawn, found.sampling, found.diagnostics
    warnings = _warnings(prepared, likelihood, drawn, plan.required_ess)
    if not found.settled:
        warnings.insert(0, _not_converged(sampling, diagnostics))
    return Posterior(
        loop=prepared.loop,
        drive=prepared.drive,
        prior=likelihood.prior,
        operation=prepared.operation,
        likelihood=likelihood,
        chains=found.chains,
        offset=found.offset.reshape(found.chains.shape[:3]),
        noise_scale=found.scale.reshape(found.chains.shape[:3]) / likelihood.widening,
        diagnostics=diagnostics,
        converged=found.converged,
        best=starts[0].point,
        turning_points=prepared.turning_points,
        kept=prepared.kept,
        record_course=prepared.record_course,
        noise_floor=prepared.noise_floor,
        sampling=sampling,
        warnings=tuple(warnings),
    )


@dataclass(frozen=True)
class _Sampled:
    """Draws of one model.

    Attributes
    ----------
    chains : (ensembles, steps, walkers, size) of points
    offset, scale : (draws,) of the angle in rad, of the noise
    diagnostics, sampling : of the chains
    settled : whether the chains came to rest
    drawn : the effects' draws where these were integrated out
    """

    chains: FloatArray
    offset: FloatArray
    scale: FloatArray
    diagnostics: Diagnostics
    sampling: dict[str, float]
    settled: bool
    drawn: EffectDraws | None

    @property
    def converged(self) -> bool:
        """Whether the draws stand for the posterior."""
        return self.settled and (self.drawn is None or self.drawn.usable)


def _sample(
    exact: LoopLikelihood,
    linearised: LinearisedEffects | None,
    temperature: float,
    starts: list[StartingPoint],
    rng: np.random.Generator,
    plan: SamplingPlan,
    parts: int,
    executor: Executor | None,
    progress: Progress,
) -> _Sampled:
    """Sample a model, its effects integrated out and drawn after, or with all else.

    At a temperature of the likelihood, which weights make up for where effects are drawn after.
    """
    likelihood = exact if linearised is None else linearised.sampled
    posterior = RidgePosterior(likelihood, temperature)
    modes = starts if linearised is None else [_without_effects(start) for start in starts]
    walkers = max(plan.walkers, 2 * likelihood.size)
    states = initial_states(posterior, modes, rng, parts, walkers=walkers)
    chains, diagnostics, sampling, settled = sample_until_converged(
        posterior, states, plan, rng, executor, progress, worth_walkers(modes)
    )
    most = plan.stored_steps if linearised is None else min(plan.stored_steps, _WITH_EFFECTS)
    stored = chains[:, :: -(-chains.shape[1] // most)]
    flat = stored.reshape(-1, likelihood.size)
    offset, scale = likelihood.nuisances(flat, rng)
    if linearised is None:
        return _Sampled(stored, offset, scale, diagnostics, sampling, settled, None)
    drawn = linearised.draws(flat, offset, scale, len(stored), rng, temperature)
    sampling |= {"pareto_k": drawn.pareto_k, "weighted_draws_effective": drawn.effective}
    if temperature != 1.0:
        sampling["temperature"] = temperature
    if drawn.weighted:
        diagnostics = diagnostics.at_most(drawn.effective)
    stored = drawn.points.reshape(*stored.shape[:3], exact.size)
    return _Sampled(stored, drawn.offset, drawn.scale, diagnostics, sampling, settled, drawn)


def _warnings(
    prepared: Prepared, likelihood: LoopLikelihood, drawn: EffectDraws | None, required_ess: float
) -> list[str]:
    """What to say of a record, of its noise, and of effects that were integrated out."""
    said = list(prepared.warnings)
    if likelihood.least_squares is not None:
        said.append(
            "What the fit leaves hangs together. Taken for noise it would lead the fit away from "
            "the readings, so the model lacks something that this record has: the parameters are "
            "those of least squares, and their intervals are as wide as errors like these make "
            "them."
        )
    elif likelihood.effective is not None:
        said.append(
            f"What the fit leaves hangs together beyond its noise model: its {likelihood.blocks} "
            f"blocks count as {likelihood.block_degrees + 1:.0f} independent ones, and intervals "
            f"are {likelihood.widening:.1f} times as wide as if all were. An error of the model "
            "that repeats is not in them."
        )
    if likelihood.effects or likelihood.noise.term is not None:
        said.append(_figures_leave_out(likelihood))
    if drawn is not None and not drawn.exact:
        said.append(
            "The effects were integrated out with a model that is linear in them, and this record "
            f"bends it: the weights that make up for it are uneven (Pareto k {drawn.pareto_k:.2f}, "
            f"at most {PARETO_K_LIMIT:.2f} is trusted; {drawn.effective:.0f} effective draws), so "
            + ("that intervals are rough." if drawn.usable else _NO_POSTERIOR)
        )
    elif drawn is not None and drawn.effective < required_ess:
        said.append(
            "The effects were integrated out with a model that is linear in them; the weights that "
            f"make up for what it bends leave {drawn.effective:.0f} effective draws, where "
            f"{required_ess:.0f} are asked for: the ends of intervals are less exact."
        )
    return said


def _weighed(
    prepared: Prepared,
    likelihood: LoopLikelihood,
    starts: list[StartingPoint],
    told: WithinBlocks | None,
) -> tuple[LoopLikelihood, list[StartingPoint]]:
    """The likelihood with as many degrees of freedom as blocks and readings are worth."""
    effective = effective_degrees(likelihood, starts[0])
    within = told or _within_blocks(prepared, likelihood, starts[0])
    if effective < likelihood.block_degrees:
        likelihood = replace(likelihood, effective=effective)
    elif within is not None:
        likelihood = replace(likelihood, within=within)
    else:
        return likelihood, starts
    return likelihood, [describe(likelihood, start.point) for start in starts]


def _within_blocks(
    prepared: Prepared, likelihood: LoopLikelihood, start: StartingPoint
) -> WithinBlocks | None:
    """What the readings inside white blocks say of their noise; None where blocks disagree."""
    noise, reduced = likelihood.noise, likelihood.reduced
    if noise.whitening is not None or reduced.path.variance is None:
        return None
    slope = local_slope(reduced.path.torque, likelihood.angle(start.point[None, :])[0])
    found = WithinBlocks.of(prepared.loop, reduced, slope, noise.white_sd * np.sqrt(reduced.count))
    residual = likelihood.residual(start.point[None, :])[0]
    degrees = likelihood.block_degrees - likelihood.size
    return found if found.agrees(float(residual @ residual), degrees) else None


def _not_converged(sampling: Mapping[str, float], diagnostics: Diagnostics) -> str:
    fewest = min(diagnostics.ess_bulk.min(), diagnostics.ess_tail.min())
    lost = ", but a mode that the search found is missing from the draws"
    return (
        f"This fit did not converge within {sampling['steps']:.0f} steps (largest R-hat "
        f"{diagnostics.rhat.max():.3f}, fewest effective draws {fewest:.0f}"
        f"{lost if 'lost_mode' in sampling else ''}): its numbers are not to be relied on."
    )


_NO_POSTERIOR = (
    "that the draws do not stand for the posterior: this fit counts as not converged, and its "
    "intervals are not to be relied on."
)
_SPOKEN = {"branch": "torque in each direction", "order": "the order of the readings"}


def _figures_leave_out(likelihood: LoopLikelihood) -> str:
    names = [spoken_effect(effect.id) for effect in likelihood.effects]
    if (term := likelihood.noise.term) is not None:
        along = _SPOKEN.get(term.coordinate, term.coordinate.replace("_", " "))
        names.append(f"the empirical curve over {along}")
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    said = (
        "The figures of merit are those of the eight parameters: what "
        f"{listed} add{'s' if len(names) == 1 else ''} to the loop is not in them."
    )
    if any(effect.lasting and effect.static for effect in likelihood.effects):
        said += " Width, loss and lost motion with what is lasting are given beside them."
    dividing = [effect for effect in likelihood.effects if effect.divides_width]
    if dividing:
        named = " and ".join(spoken_effect(effect.id) for effect in dividing)
        said += (
            f" How much of the width and loss is the drive's and how much belongs to {named} hangs "
            "on the assumed shape, and their intervals hold no more than shapes near it."
        )
        if all(effect.static for effect in dividing):
            said += " Go by width and loss with it."
    return said


def _without_effects(start: StartingPoint) -> StartingPoint:
    """The mode in the nine coordinates that are sampled; the effects are integrated out."""
    return replace(
        start, point=start.point[: COUNT + 1], covariance=start.covariance[: COUNT + 1, : COUNT + 1]
    )
