"""Fit one loop: reduce, find the modes, test the noise, sample until converged."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.reduce import ReducedLoop, reduce_loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.diagnostics import LENGTHS, Diagnostics, autocorrelation_time, diagnose
from hdprog.inference.likelihood import COUNT, LoopLikelihood, sigmoid
from hdprog.inference.measured_noise import block_noise, local_slope, reading_noise, spikes
from hdprog.inference.mixture_proposal import GaussianMixture, fit_mixture
from hdprog.inference.noise import NoiseModel, fit_noise
from hdprog.inference.posterior import Posterior
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.priors import Prior, RecordScales
from hdprog.inference.sampler import (
    DIMENSIONS,
    ENSEMBLES,
    WALKERS,
    EnsembleState,
    RidgePosterior,
    initial_states,
    sample_ensemble,
)
from hdprog.inference.starting_points import StartingPoint, starting_points
from hdprog.physics.figures import Operation
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

Progress = Callable[[str, int, int], None]
_SLOW = 12.0  # autocorrelation time in steps above which the proposal is fitted anew
_MIXTURE_DRAWS = 6000


@dataclass(frozen=True)
class SamplingPlan:
    """How long to sample.

    Attributes
    ----------
    required_ess : bulk and tail effective draws of every parameter
    warm_up_steps : lengths of the warm-up's parts; behind each the proposal is fitted anew
    components : Gaussians of the proposal behind each part
    first_steps : steps before the first look
    most_steps : bound, warm-up included; past it the posterior is marked as not converged
    refits : times that the proposal is fitted anew where sampling stays slow
    stored_steps : steps kept for each walker after thinning
    """

    required_ess: float = 1000.0
    warm_up_steps: tuple[int, ...] = (350, 60, 90)
    components: tuple[int, ...] = (3, 6, 8)
    first_steps: int = 300
    most_steps: int = 12_000
    refits: int = 4
    stored_steps: int = 125


FULL = SamplingPlan()
QUICK = SamplingPlan(
    required_ess=400.0, first_steps=150, most_steps=4000, refits=2, stored_steps=60
)


@dataclass(frozen=True)
class _Prepared:
    likelihood: LoopLikelihood
    starts: list[StartingPoint]
    turning_points: NDArray[np.intp]
    kept: NDArray[np.bool_]
    record_path: TorquePath
    noise_floor: float


def operation_of(drive: Drive, prior: Prior, loop: Loop) -> tuple[Operation, str | None]:
    """The torques that a drive's figures refer to, and a remark where the record must stand in."""
    largest = float(np.max(np.abs(loop.torque)))
    rated, remark = drive.rated_torque, None
    if rated is None:
        rated = largest
        remark = (
            f"The drive's rated torque is not given: figures of merit refer to {largest:.3g} Nm, "
            "the record's largest torque. Set rated_torque_Nm in drive.toml to compare tests."
        )
    reference = drive.reference_torque if drive.reference_torque is not None else rated
    return Operation(drive.alpha, reference, rated, prior.catalogue_torques), remark


def fit_loop(
    loop: Loop,
    drive: Drive,
    rng: np.random.Generator,
    *,
    prior: Prior | None = None,
    plan: SamplingPlan = FULL,
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
    plan : how long to sample
    executor : runs the ensembles side by side; in this process if None
    progress : called with stage, effective lengths done and wanted

    Returns
    -------
    Posterior, marked where it did not converge

    Raises
    ------
    BadInputError
        if the drive names a prior that does not exist
    """
    warnings = list(loop.warnings)
    if prior is None:
        prior, remark = prior_of_drive(drive, RecordScales.of(loop.torque, loop.angle))
        warnings += [remark] if remark else []
    operation, remark = operation_of(drive, prior, loop)
    warnings += [remark] if remark else []
    if not drive.alpha_declared:
        warnings.append(
            f"The gear-tooth angle is not declared: {math.degrees(drive.alpha):.0f}° is assumed. "
            "K_W and mu depend on it; stiffness and width hardly do."
        )
    prepared = _prepare(loop, drive, prior, rng)
    posterior = RidgePosterior(prepared.likelihood)
    states = initial_states(posterior, prepared.starts, rng)
    chains, diagnostics, sampling, converged = _sample(
        posterior, states, plan, rng, executor, progress
    )
    stored = chains[:, :: max(1, chains.shape[1] // plan.stored_steps)]
    flat = stored.reshape(-1, COUNT + 1)
    offset, scale = prepared.likelihood.nuisances(flat[:, :COUNT], sigmoid(flat[:, COUNT]), rng)
    if not converged:
        warnings.insert(
            0,
            f"This fit did not converge within {sampling['steps']:.0f} steps (largest R-hat "
            f"{diagnostics.rhat.max():.3f}, fewest effective draws "
            f"{min(diagnostics.ess_bulk.min(), diagnostics.ess_tail.min()):.0f}): its numbers "
            "are not to be relied on.",
        )
    return Posterior(
        loop=loop,
        drive=drive,
        prior=prior,
        operation=operation,
        likelihood=prepared.likelihood,
        chains=stored,
        offset=offset.reshape(stored.shape[:3]),
        noise_scale=scale.reshape(stored.shape[:3]),
        diagnostics=diagnostics,
        converged=converged,
        best=prepared.starts[0].point,
        turning_points=prepared.turning_points,
        kept=prepared.kept,
        record_path=prepared.record_path,
        noise_floor=prepared.noise_floor,
        sampling=sampling,
        effects=(),
        warnings=tuple(warnings),
    )


def _prepare(loop: Loop, drive: Drive, prior: Prior, rng: np.random.Generator) -> _Prepared:
    """Reduce the record, set spikes aside, find the modes and the shape of the noise."""
    points = turning_points(loop.torque)
    torque_noise, angle_noise = reading_noise(loop, drive.noise)
    kept = np.ones(len(loop), dtype=bool)
    reduced = reduce_loop(loop, points, torque_noise)
    likelihood = _white(reduced, drive, prior, reduced.angle, torque_noise, angle_noise)
    starts = starting_points(likelihood, rng)
    whole = TorquePath(
        loop.torque,
        np.concatenate([[0], points[1:-1] + 1]),
        reduced.path.rising,
        reversal_torque=reduced.path.reversal_torque,
    )
    residual = loop.angle - _best_angle(likelihood.at_path(whole), starts[0])
    spiked = spikes(residual)
    if spiked.any():
        kept = ~spiked
        reduced = reduce_loop(loop, points, torque_noise, kept)
    fitted = _best_angle(likelihood.at_path(reduced.path), starts[0])
    likelihood = _white(reduced, drive, prior, fitted, torque_noise, angle_noise)
    starts = starting_points(likelihood, rng)
    residual, sensitivities = _unwhitened(likelihood, starts[0])
    position = reduced.time if reduced.time is not None else reduced.position
    noise = fit_noise(residual, sensitivities, likelihood.noise.sd, position)
    if noise.whitening is not None:
        likelihood = LoopLikelihood(reduced, prior, drive.alpha, noise)
        starts = starting_points(likelihood, rng)
    return _Prepared(likelihood, starts, points, kept, whole, angle_noise)


def _white(
    reduced: ReducedLoop,
    drive: Drive,
    prior: Prior,
    course: FloatArray,
    torque_noise: float,
    angle_noise: float,
) -> LoopLikelihood:
    slope = local_slope(reduced.path.torque, course)
    sd = block_noise(reduced, slope, torque_noise, angle_noise)
    return LoopLikelihood(reduced, prior, drive.alpha, NoiseModel.white(sd))


def _best_angle(likelihood: LoopLikelihood, start: StartingPoint) -> FloatArray:
    angles = likelihood.angle(start.point[None, :COUNT], sigmoid(start.point[COUNT:]))
    return np.asarray(angles[0])


def _unwhitened(likelihood: LoopLikelihood, start: StartingPoint) -> tuple[FloatArray, FloatArray]:
    """Residual (blocks,) and sensitivities (blocks, 10), offset among them, in rad."""
    sd = likelihood.noise.sd
    residual, derivative = likelihood.jacobian(start.point[:COUNT], float(start.point[COUNT]))
    ones = np.ones((sd.size, 1))
    return residual * sd, np.hstack([derivative * sd[:, None], ones])


def _sample(
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
        steps: int, mixture: GaussianMixture | None
    ) -> tuple[FloatArray, float, list[EnsembleState]]:
        nonlocal steps_done
        many = len(states)
        results = list(
            spread(sample_ensemble, [posterior] * many, states, [steps] * many, [mixture] * many)
        )
        steps_done += steps
        chains = np.stack([chain for chain, _, _ in results])
        accepted = float(np.mean([share for _, share, _ in results]))
        return chains, accepted, [state for _, _, state in results]

    mixture = None
    for number, steps in enumerate(plan.warm_up_steps):
        chains, _, states = advance(steps, mixture)
        mixture = fit_mixture(_some(chains[:, steps // 2 :]), plan.components[number], rng)
    warm_up = steps_done
    ridge, accepted, states = advance(plan.first_steps, mixture)
    refits = 0
    while True:
        tau = float(autocorrelation_time(ridge).max())
        if tau > _SLOW and refits < plan.refits:
            # The proposal misses part of the posterior: what was seen so far becomes warm-up.
            mixture = fit_mixture(_some(ridge), plan.components[-1] + 4 * refits + 2, rng)
            warm_up, refits = steps_done, refits + 1
            ridge, accepted, states = advance(plan.first_steps * refits, mixture)
            continue
        wanted = max(plan.first_steps, math.ceil(LENGTHS * tau))
        total = ridge.shape[1]
        if progress is not None:
            progress("sampling", min(total, wanted), wanted)
        if total >= wanted or steps_done >= plan.most_steps:
            chains = _unconstrained(posterior, ridge[:, :: max(1, int(tau / 2))])
            diagnostics = diagnose(chains)
            converged = total >= wanted and diagnostics.passes(plan.required_ess)
            if converged or steps_done >= plan.most_steps:
                break
            wanted = int(1.5 * total)
        more, _, states = advance(min(wanted - total, plan.most_steps - steps_done), mixture)
        ridge = np.concatenate([ridge, more], axis=1)
    sampling = {
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
    pooled = ridge.reshape(-1, DIMENSIONS)
    chosen = np.linspace(0, len(pooled) - 1, min(len(pooled), _MIXTURE_DRAWS)).astype(int)
    return np.asarray(pooled[chosen])


def _unconstrained(posterior: RidgePosterior, ridge: FloatArray) -> FloatArray:
    flat = posterior.coordinates(ridge.reshape(-1, COUNT + 1))
    return flat.reshape(ridge.shape)
