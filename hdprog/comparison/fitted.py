"""One model fitted to a prepared record, with all that the comparison wants of it."""

from __future__ import annotations

import inspect
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hdprog.comparison.curves import SteadyCycle, local_stiffness
from hdprog.comparison.drawn import Drawn, drive_draws, other_draws
from hdprog.comparison.results import DRIVE, ModelParameterSummary, StiffnessBand
from hdprog.discovery.errors_of_fit import error_figures
from hdprog.discovery.heldout import HeldOut, held_out
from hdprog.discovery.model import Model
from hdprog.explanation import ErrorFigures
from hdprog.inference.lazy_arviz import arviz
from hdprog.inference.likelihood import COUNT
from hdprog.inference.other_likelihood import OtherLikelihood
from hdprog.inference.other_starts import refit
from hdprog.inference.prepare import Prepared
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.figures import stiffness_curve
from hdprog.physics.other_models import BY_ID
from hdprog.physics.other_models.base import values_of
from hdprog.physics.parameters import PARAMETERS, FloatArray
from hdprog.results import LEVELS, LoopFit, by_level

_LOO_DRAWS = 1600
_CURVE_DRAWS = 300
_FIT_DRAWS = 400
_RECORD_DRAWS = 8
_DOUBTFUL = 0.7


@dataclass(frozen=True)
class Fitted:
    """One model on the record, before it is ranked among the others.

    Attributes
    ----------
    loo : ArviZ's ELPDData, pointwise
    doubtful_blocks : share of blocks with a Pareto k above 0.7
    held : what it says of the parts it did not see
    other attributes : as in `ComparedModel`
    """

    id: str
    words: str
    source: str
    where: str
    equation: str
    parameters: Mapping[str, ModelParameterSummary]
    loo: Any
    doubtful_blocks: float
    held: HeldOut
    errors: ErrorFigures
    width: Mapping[float, float]
    stiffness: StiffnessBand | None
    fit: LoopFit
    converged: bool
    method: str
    noise_model: str
    sampling: Mapping[str, float]
    seconds: float


def fit_model(
    prepared: Prepared,
    model_id: str,
    cycle: SteadyCycle,
    rng: np.random.Generator,
    plan: SamplingPlan,
) -> Fitted:
    """Fit the drive model or another model, predict its left-out parts, read its curves.

    Parameters
    ----------
    prepared : the record
    model_id : "drive" or the id of a model that can be defined on the record
    cycle : that widths and stiffnesses are read on
    rng : source of randomness
    plan : how long to sample
    """
    started = time.perf_counter()
    drawn = (
        drive_draws(prepared, rng, plan)
        if model_id == DRIVE
        else other_draws(prepared, model_id, rng, plan)
    )
    likelihood = drawn.likelihood
    model = Model(likelihood, drawn.starts)
    if isinstance(likelihood, OtherLikelihood):
        held = held_out(prepared, model, refit)
    else:
        held = held_out(prepared, model)
    residual = _record_residual(prepared, drawn)
    width, stiffness = _curves(drawn, cycle)
    loo, doubtful = _loo(drawn)
    words, source, where, equation = _identity(model_id)
    return Fitted(
        id=model_id,
        words=words,
        source=source,
        where=where,
        equation=equation,
        parameters=_parameters(drawn),
        loo=loo,
        doubtful_blocks=doubtful,
        held=held,
        errors=error_figures(prepared, residual, held),
        width=width,
        stiffness=stiffness,
        fit=_along(drawn),
        converged=drawn.converged,
        method=drawn.method,
        noise_model=likelihood.noise.words,
        sampling=dict(drawn.sampling),
        seconds=time.perf_counter() - started,
    )


def _identity(model_id: str) -> tuple[str, str, str, str]:
    """Words, source, where it says something, and equation."""
    if model_id == DRIVE:
        return (
            "drive model (hdprog)",
            "eqs 15-28",
            "any record with a reversal",
            "Δθ = T/K_F + Δθ_T(T) + tan(α)·y (21), y the slip between its envelopes (26, 28)",
        )
    model = BY_ID[model_id]
    first = inspect.getdoc(type(model)) or ""
    return model.words, model.source, model.where, first.partition("\n\n")[0].replace("\n", " ")


def _loo(drawn: Drawn) -> tuple[Any, float]:
    """PSIS-LOO over the blocks, each given those before it, and the share that is doubtful."""
    ensembles = drawn.chains.shape[0]
    points, offset, scale = drawn.flat(_LOO_DRAWS)
    count = len(points) // ensembles * ensembles
    chosen = np.linspace(0, len(points) - 1, count).astype(int)
    density = drawn.likelihood.pointwise(points[chosen], offset[chosen], scale[chosen])
    density = density.reshape(ensembles, -1, density.shape[-1])
    stats = arviz()
    bulk = drawn.diagnostics.ess_bulk
    efficiency = float(min(1.0, np.median(bulk) / count)) if bulk.size else 1.0
    # Draws for their own sake: ArviZ asks for a posterior beside the densities.
    data = stats.from_dict(
        posterior={"noise_scale": scale[chosen].reshape(ensembles, -1)},
        log_likelihood={"angle": density},
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # on Pareto k, which is handed on instead
        loo = stats.loo(data, pointwise=True, reff=efficiency)
    return loo, float(np.mean(loo.pareto_k.values > _DOUBTFUL))


def _record_residual(prepared: Prepared, drawn: Drawn) -> FloatArray:
    """(samples,) measured less fitted angle at every reading, in rad."""
    whole = drawn.likelihood.at_course(prepared.record_course)
    points = drawn.flat(_RECORD_DRAWS)[0]
    residual = prepared.loop.angle - whole.angle(points).mean(axis=0)
    return np.asarray(residual - residual[prepared.kept].mean())


def _along(drawn: Drawn) -> LoopFit:
    """The fit along the blocks of the record."""
    points, offset, scale = drawn.flat(_FIT_DRAWS)
    likelihood = drawn.likelihood
    angles = likelihood.angle(points) + offset[:, None]
    low, fitted, high = np.quantile(angles, (0.05, 0.5, 0.95), axis=0)
    reduced = likelihood.reduced
    return LoopFit(
        torque=reduced.path.torque,
        angle=reduced.angle,
        count=reduced.count,
        fitted=fitted,
        low=low,
        high=high,
        residual=reduced.angle - fitted,
        noise=float(np.median(scale)) * likelihood.noise.sd,
        position=reduced.position,
    )


def _parameters(drawn: Drawn) -> dict[str, ModelParameterSummary]:
    likelihood, diagnostics = drawn.likelihood, drawn.diagnostics
    total = int(np.prod(drawn.chains.shape[:3]))
    points = drawn.chains.reshape(total, -1) if drawn.chains.size else np.empty((total, 0))
    if isinstance(likelihood, OtherLikelihood):
        named = [(one.name, one.unit, one.meaning) for one in likelihood.parameters]
        values = {name: column[:, 0] for name, column in likelihood.values(points).items()}
    else:
        named = [(one.name, one.unit, one.meaning) for one in PARAMETERS]
        values = dict(likelihood.prior.to_physical(points[:, :COUNT]))
    spread = likelihood.prior_sd**2
    if isinstance(likelihood, OtherLikelihood) and likelihood.model.nonnegative:
        spread = spread * (1 - 2 / np.pi)  # of a half-normal prior
    return {
        name: ModelParameterSummary(
            unit=unit,
            meaning=meaning,
            quantiles=by_level(values[name]),
            rhat=float(diagnostics.rhat[index]),
            ess_bulk=float(diagnostics.ess_bulk[index]),
            ess_tail=float(diagnostics.ess_tail[index]),
            contraction=float(1 - points[:, index].var() / spread[index]),
        )
        for index, (name, unit, meaning) in enumerate(named)
    }


def _curves(drawn: Drawn, cycle: SteadyCycle) -> tuple[dict[float, float], StiffnessBand | None]:
    """Quantiles of the width in rad, and the band of the local stiffness."""
    likelihood = drawn.likelihood
    points = drawn.flat(_CURVE_DRAWS)[0]
    edges = cycle.edges
    if isinstance(likelihood, OtherLikelihood):
        model, setting = likelihood.model, likelihood.setting
        values = values_of(likelihood.parameters, points)
        torque = np.unique(np.append(edges, cycle.width_torque))
        rising, falling = cycle.branches(
            torque,
            lambda course: np.broadcast_to(
                model.angle(course, values, setting), (len(points), course.path.torque.size)
            ),
        )
        curve = model.stiffness_curve(edges, values, setting)
        if curve is None:
            curve = 0.5 * (rising + falling)[:, np.searchsorted(torque, edges)]
    else:
        parameters = likelihood.prior.to_physical(points[:, :COUNT])
        torque = np.array([cycle.width_torque])
        rising, falling = cycle.branches(
            torque, lambda course: torsion_angle(course.path, parameters, likelihood.alpha)
        )
        curve = stiffness_curve(edges, parameters, likelihood.alpha)
    at = int(np.searchsorted(torque, cycle.width_torque))
    width = by_level((falling - rising)[:, at])
    found = local_stiffness(edges, curve)
    if found is None:
        return width, None
    quantiles = np.nanquantile(found, LEVELS, axis=0)
    middles = 0.5 * (edges[1:] + edges[:-1])
    return width, StiffnessBand(middles, dict(zip(LEVELS, quantiles, strict=True)))
