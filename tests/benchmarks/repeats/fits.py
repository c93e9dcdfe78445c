"""Fits of repeats: with the noise that a fit finds, and with white noise in spite of it."""

from __future__ import annotations

import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.discovery.model import Model
from hdprog.discovery.search import trace
from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, prepare, settle_noise
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.priors import Prior, RecordScales
from hdprog.inference.sampling_plan import QUICK
from hdprog.inference.starting_points import StartingPoint, descend_all, describe
from hdprog.physics.figures import FigureRequest, Operation, figures
from hdprog.physics.parameters import NAMES, FloatArray, Parameters, in_support
from tests.benchmarks.repeats import DRIVE, LEVELS, WHITE, WIDENED, Fit
from tests.benchmarks.repeats.records import Group, direct_figures
from tests.inference.inverse import coordinates_of

SEED = 83
PLAN = QUICK
T1_SHARE, T2_SHARE = 14 / 63, 48 / 63
"""Of the torque, where the makers' stiffness of size 25 changes (their catalogue's T1, T2)."""
_PRIOR_DRAWS = 2000


def rng_of(*key: object) -> np.random.Generator:
    """Random numbers of a job, always the same."""
    return np.random.default_rng([SEED, zlib.crc32(repr(key).encode())])


def requests_at(torque: float) -> tuple[FigureRequest, ...]:
    """The figures that are compared."""
    return (
        FigureRequest("hysteresis_width_arcmin"),
        FigureRequest("hysteresis_loss_J"),
        FigureRequest("lost_motion_arcmin"),
        FigureRequest("secant_stiffness_Nm_per_rad", torque),
        FigureRequest("K1_Nm_per_rad"),
        FigureRequest("K2_Nm_per_rad"),
        FigureRequest("K3_Nm_per_rad"),
    )


FIGURES = tuple(one.quantity for one in requests_at(1.0))
QUANTITIES = (*FIGURES, *NAMES)


def shared_prior(loops: Sequence[Loop], drive: Drive) -> Prior:
    """One prior for all repeats, so that their own scales do not pull them apart."""
    torque = np.concatenate([loop.torque for loop in loops])
    spans = np.median([np.ptp(loop.angle) for loop in loops])
    angle = np.array([0.0, float(spans)])
    return prior_of_drive(drive, RecordScales.of(torque, angle))[0]


def fits_of(group: Group, model: str, code: str) -> Iterator[Fit]:
    """Every repeat of a group under one model, with both noises."""
    drive = replace(Drive.default(), rated_torque=group.torque)
    prior = shared_prior(group.loops, drive)
    prepared = [
        prepare(loop, drive, rng_of(group.name, cycle), prior=prior)
        for cycle, loop in enumerate(group.loops)
    ]
    for cycle, pairs in enumerate(_models(group.name, prepared, model)):
        direct = direct_figures(group.loops[cycle], group.torque)
        for noise, (likelihood, starts) in pairs.items():
            fit = Fit(group.name, cycle, model, noise, code, direct=direct)
            yield sampled(fit, prepared[cycle], likelihood, starts)


def _models(
    name: str, prepared: Sequence[Prepared], model: str
) -> Iterator[dict[str, tuple[LoopLikelihood, list[StartingPoint]]]]:
    """Of each repeat the model with either noise, and its modes."""
    if model == DRIVE:
        for cycle, one in enumerate(prepared):
            rng = rng_of(name, cycle, "noise")
            yield {
                WIDENED: settle_noise(one.likelihood, one.starts, rng),
                WHITE: (one.likelihood, one.starts),
            }
        return
    # All repeats together, as `hdprog explain FOLDER` does with the tests of one drive.
    seeds = [
        np.random.SeedSequence([SEED, zlib.crc32(name.encode()), cycle])
        for cycle in range(len(prepared))
    ]
    for traced in trace(prepared, seeds):
        final = traced.final
        yield {
            WIDENED: (final.likelihood, list(final.starts)),
            WHITE: _with_white_noise(final),
        }


def _with_white_noise(final: Model) -> tuple[LoopLikelihood, list[StartingPoint]]:
    """The same effects, the correlated part of the noise taken out."""
    likelihood, noise = final.likelihood, final.likelihood.noise
    white = noise.as_white
    if noise.term is not None:
        white = white.with_term(noise.term, likelihood.reduced.course)
    likelihood = replace(likelihood, noise=white)
    points = [start.point for start in final.starts]
    found = descend_all(likelihood, points) or [describe(likelihood, points[0])]
    return likelihood, sorted(found, key=lambda start: start.deviance)


def sampled(
    fit: Fit,
    prepared: Prepared,
    likelihood: LoopLikelihood,
    starts: list[StartingPoint],
    truth: Parameters | None = None,
) -> Fit:
    """Sample a posterior and fill in what it says."""
    rng = rng_of(fit.group, fit.cycle, fit.model, fit.noise)
    started = time.process_time()
    try:
        posterior = sample_posterior(prepared, likelihood, starts, rng, plan=PLAN)
        _describe(fit, posterior, starts[0])
        values = _values(posterior.parameters, posterior.operation, prepared.likelihood.prior)
        values |= _whole(posterior)
        wide = _prior_values(prepared.likelihood.prior, posterior.operation, rng)
        for name in QUANTITIES:
            draws = values[name]
            fit.mean[name], fit.sd[name] = float(draws.mean()), float(draws.std())
            fit.quantiles[name] = np.quantile(draws, LEVELS).tolist()
            fit.contraction[name] = float(1 - draws.var() / wide[name].var())
        if truth is not None:
            known = _values(truth, posterior.operation, prepared.likelihood.prior)
            fit.truth = {name: float(known[name][0]) for name in QUANTITIES}
    except Exception as error:  # one fit that fails must not end the run; it is counted
        fit.status, fit.reason = "failed", f"{type(error).__name__}: {error}"
    fit.seconds = time.process_time() - started
    return fit


def _describe(fit: Fit, posterior: Posterior, best: StartingPoint) -> None:
    likelihood = posterior.likelihood
    noise, reduced = likelihood.noise, likelihood.reduced
    fit.converged = posterior.converged
    fit.readings, fit.blocks = len(posterior.loop), likelihood.blocks
    if noise.log_ratio is not None and noise.correlation_length is not None:
        fit.correlated = True
        fit.ou_share = float(1 / (1 + np.exp(-noise.log_ratio)))
        fit.ou_length = noise.correlation_length / float(np.ptp(reduced.moment))
    left = reduced.angle - likelihood.angle(best.point[None, :])[0]
    left = left - likelihood.offset(left)
    left = left - noise.smooth_part(left)
    fit.residual_rad = float(np.sqrt(np.average((left - left.mean()) ** 2, weights=reduced.count)))
    fit.effects = [effect.id for effect in likelihood.effects]
    if noise.term is not None:
        fit.effects.append(f"unknown over {noise.term.coordinate}")


def _operation(operation: Operation) -> Operation:
    """With the torques of K1 to K3, which no catalogue gives for these drives."""
    top = operation.reference_torque
    return replace(operation, catalogue_torques=(T1_SHARE * top, T2_SHARE * top))


def _values(parameters: Parameters, operation: Operation, prior: Prior) -> dict[str, FloatArray]:
    """Every quantity, (draws,) each: stiffnesses in logs, parameters in their coordinates."""
    operation = _operation(operation)
    found = figures(requests_at(operation.reference_torque), parameters, operation)
    named = {key.split("@")[0]: np.asarray(value) for key, value in found.items()}
    for name in FIGURES:
        if name.endswith("Nm_per_rad"):
            named[name] = np.log(named[name])
    coordinates = np.atleast_2d(coordinates_of(prior, parameters))
    return named | {name: coordinates[:, at] for at, name in enumerate(NAMES)}


def _whole(posterior: Posterior) -> Mapping[str, FloatArray]:
    """Width, loss and lost motion with the lasting effects, where there are any."""
    return posterior.figures_with_effects() if posterior.likelihood.effects else {}


def _prior_values(
    prior: Prior, operation: Operation, rng: np.random.Generator
) -> dict[str, FloatArray]:
    drawn = prior.to_physical(prior.sample(_PRIOR_DRAWS, rng))
    inside = in_support(drawn, operation.alpha)
    return _values({name: values[inside] for name, values in drawn.items()}, operation, prior)
