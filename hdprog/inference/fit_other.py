"""Fit a model other than the drive model to a prepared record, and sample its posterior."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.block_detail import bend
from hdprog.inference.diagnostics import Diagnostics, diagnose
from hdprog.inference.effective_blocks import effective_degrees
from hdprog.inference.noise import NoiseModel
from hdprog.inference.other_likelihood import OtherLikelihood, PlainPosterior
from hdprog.inference.other_starts import least_squares, other_starts
from hdprog.inference.prepare import Prepared, noise_about
from hdprog.inference.sampler import ENSEMBLES, initial_states
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.inference.starting_points import StartingPoint, describe
from hdprog.inference.truncated_gaussian import sample_weights
from hdprog.inference.until_converged import sample_until_converged
from hdprog.physics.other_models.base import OtherModel, Setting
from hdprog.physics.other_models.nonnegative import HISTORIES, NonnegativeModel
from hdprog.physics.parameters import FloatArray

_WALKERS_A_DIMENSION = 4
_BURN_IN = 60  # draws of a chain of weights
_LONGEST = 8  # times its first length, to which a chain of weights is extended
_FIXED_DRAWS = 250  # of a model with nothing to fit, a chain


@dataclass(frozen=True)
class OtherPosterior:
    """Draws of a model's posterior.

    Attributes
    ----------
    likelihood : of the model, noise included
    starts : modes, best first
    chains : (ensembles, steps, walkers, size) thinned draws of coordinates
    offset, noise_scale : (ensembles, steps, walkers), rad and -
    diagnostics : of the chains as sampled, before they are thinned; quantities as in `chains`
    converged : R-hat, ESS and length all reached what they must
    sampling : numbers of the run by name
    method : how it was sampled, in words
    """

    likelihood: OtherLikelihood
    starts: tuple[StartingPoint, ...]
    chains: FloatArray
    offset: FloatArray
    noise_scale: FloatArray
    diagnostics: Diagnostics
    converged: bool
    sampling: dict[str, float]
    method: str


def fit_other(
    prepared: Prepared, model: OtherModel, rng: np.random.Generator, plan: SamplingPlan
) -> OtherPosterior:
    """Posterior of a model on a prepared record.

    Parameters
    ----------
    prepared : the record, reduced and its spikes set aside as for the drive model
    model : that can be defined on it
    rng : the only source of randomness
    plan : how long to sample
    """
    likelihood = _described(prepared, model)
    starts = other_starts(likelihood, rng)
    if not model.needs:
        # A block's mean angle differs from the angle at its mean torque by what the model bends.
        # Inside a block torque alone is known: a model that needs more does without.
        straight = likelihood.reduced.angle
        reduced = replace(likelihood.reduced, angle=straight - bend(likelihood, starts[0]))
        likelihood = replace(likelihood, reduced=reduced)
    known = np.array([start.point for start in starts])
    starts = other_starts(likelihood, rng, known)
    noise = noise_about(likelihood, starts[0])
    if noise.whitening is not None:
        likelihood = replace(likelihood, noise=noise)
        starts = other_starts(likelihood, rng, known)
    degrees = effective_degrees(likelihood, starts[0])
    if degrees < likelihood.block_degrees:
        likelihood = replace(likelihood, effective=degrees)
        if not model.nonnegative:
            starts = [describe(likelihood, start.point) for start in starts]
    if likelihood.size == 0:
        return _fixed(likelihood, starts, rng)
    if model.nonnegative:
        return _weights(likelihood, starts, rng, plan)
    return _ensembles(likelihood, starts, rng, plan)


def _described(prepared: Prepared, model: OtherModel) -> OtherLikelihood:
    """Likelihood with the record's own noise; of a nonnegative model, behind its best history."""
    drive = prepared.likelihood
    reduced = drive.reduced
    reduced = replace(reduced, angle=reduced.angle + bend(drive, prepared.starts[0]))
    likelihood = OtherLikelihood(
        reduced,
        drive.prior,
        drive.alpha,
        NoiseModel.white(drive.noise.white_sd),
        model=model,
        setting=Setting.of(prepared.record_course, drive.prior.catalogue_torques),
    )
    if not isinstance(model, NonnegativeModel):
        return likelihood
    behind = [replace(likelihood, model=model.after(history)) for history in HISTORIES]
    return min(behind, key=lambda one: least_squares(one).deviance)


def _fixed(
    likelihood: OtherLikelihood, starts: list[StartingPoint], rng: np.random.Generator
) -> OtherPosterior:
    """A model with nothing to fit: offset and noise scale alone, from their exact posterior."""
    nothing = np.empty(0)
    return _posterior(
        likelihood,
        starts,
        np.zeros((ENSEMBLES, _FIXED_DRAWS, 1, 0)),
        rng,
        Diagnostics(nothing, nothing, nothing),
        True,
        {"ensembles": float(ENSEMBLES), "steps": float(_FIXED_DRAWS)},
        "offset and noise scale drawn from their exact posterior; nothing else to fit",
    )


def _weights(
    likelihood: OtherLikelihood,
    starts: list[StartingPoint],
    rng: np.random.Generator,
    plan: SamplingPlan,
) -> OtherPosterior:
    """Nonnegative weights, by independent chains of exact Hamiltonian steps."""
    data = likelihood.residual(np.zeros((1, likelihood.size)))[0]
    design = likelihood.project(likelihood.design.T).T
    length = int(plan.first_steps)
    chains = np.empty((ENSEMBLES, 0, 1, likelihood.size))
    # Overdispersed: each chain begins with its weights stretched by a factor of its own.
    first = starts[0].point * rng.uniform(0.2, 2.0, (ENSEMBLES, likelihood.size)) + 1e-3
    current = sample_weights(data, design, likelihood.degrees, first, _BURN_IN, rng)[:, -1]
    converged = False
    while not converged and chains.shape[1] < _LONGEST * length:
        more = sample_weights(data, design, likelihood.degrees, current, length, rng)
        current = more[:, -1]
        chains = np.concatenate([chains, more[:, :, None, :]], axis=1)
        diagnostics = diagnose(chains)
        converged = diagnostics.passes(plan.required_ess)
    stored = chains[:, :: -(-chains.shape[1] // (4 * plan.stored_steps))]
    return _posterior(
        likelihood,
        starts,
        stored,
        rng,
        diagnostics,
        converged,
        {"ensembles": float(ENSEMBLES), "steps": float(chains.shape[1])},
        "weights at zero or above, by exact Hamiltonian steps in four independent chains",
    )


def _ensembles(
    likelihood: OtherLikelihood,
    starts: list[StartingPoint],
    rng: np.random.Generator,
    plan: SamplingPlan,
) -> OtherPosterior:
    """The other parametric models, by independent emcee ensembles like the drive model."""
    posterior = PlainPosterior(likelihood)
    walkers = max(plan.walkers, _WALKERS_A_DIMENSION * likelihood.size)
    states = initial_states(posterior, starts, rng, walkers=walkers)
    chains, diagnostics, sampling, converged = sample_until_converged(posterior, states, plan, rng)
    del sampling["evaluations"]
    every = -(-chains.shape[1] // plan.stored_steps)
    return _posterior(
        likelihood,
        starts,
        chains[:, ::every],
        rng,
        diagnostics,
        converged,
        sampling,
        ensembles_in_words(sampling),
    )


def ensembles_in_words(sampling: Mapping[str, float]) -> str:
    """How a run of `sample_until_converged` sampled, from the numbers that it gives."""
    ensembles, walkers = sampling["ensembles"], sampling["walkers"]
    return f"{ensembles:.0f} independent emcee ensembles of {walkers:.0f} walkers"


def _posterior(
    likelihood: OtherLikelihood,
    starts: list[StartingPoint],
    chains: FloatArray,
    rng: np.random.Generator,
    diagnostics: Diagnostics,
    converged: bool,
    sampling: dict[str, float],
    method: str,
) -> OtherPosterior:
    offset, scale = likelihood.nuisances(
        chains.reshape(int(np.prod(chains.shape[:3])), likelihood.size), rng
    )
    return OtherPosterior(
        likelihood,
        tuple(starts),
        chains,
        offset.reshape(chains.shape[:3]),
        scale.reshape(chains.shape[:3]) / likelihood.widening,
        diagnostics,
        converged,
        sampling,
        method,
    )
