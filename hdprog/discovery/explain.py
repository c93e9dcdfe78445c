"""A record before and after: what was added, why, and what it changes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hdprog.data.noise_level import quantisation_step
from hdprog.discovery.considered import considered
from hdprog.discovery.errors_of_fit import branch_rmse, error_figures
from hdprog.discovery.found import EFFECT_DRAWS, found_effects
from hdprog.discovery.heldout import held_out
from hdprog.discovery.model import Model
from hdprog.discovery.residuals import carriers, repeatability
from hdprog.discovery.search import Traced
from hdprog.discovery.verdict import verdict_of
from hdprog.explanation import (
    UNKNOWN,
    Carrier,
    ErrorFigures,
    Explanation,
    ResidualCourse,
    Verdict,
)
from hdprog.inference.effect_starts import strained
from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared
from hdprog.inference.sampling_plan import FULL, QUICK, SamplingPlan
from hdprog.inference.summarise import figure_requests
from hdprog.physics.coordinates import coordinates
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.results import by_level

# The drive model alone where it misfits: it shows the shift, and many hardly ever mix well.
_BESIDE = replace(
    QUICK,
    required_ess=200.0,
    lengths=15.0,
    warm_up_steps=(60, 30, 30, 40),
    first_steps=60,
    refits=1,
    most_steps=2000,
)
_OF_STEPS = 0.8  # of the error that is left: the steps' part from which they are most of it


@dataclass(frozen=True)
class Closed:
    """An explanation with the posteriors behind it; they are one where nothing was added."""

    explanation: Explanation
    before: Posterior
    after: Posterior


def sample_final(traced: Traced, rng: np.random.Generator, plan: SamplingPlan = FULL) -> Posterior:
    """Posterior of the final model."""
    return _sample(traced.prepared, traced.final, rng, plan)


def sample_base(traced: Traced, rng: np.random.Generator) -> Posterior | None:
    """Posterior of the drive model alone, sampled briefly; None where nothing was added to it."""
    if traced.final is traced.base:
        return None
    return _sample(traced.prepared, traced.base, rng, _BESIDE)


def _sample(
    prepared: Prepared, model: Model, rng: np.random.Generator, plan: SamplingPlan
) -> Posterior:
    return sample_posterior(prepared, model.likelihood, list(model.starts), rng, plan=plan)


def explain(
    traced: Traced,
    before: Posterior | None,
    after: Posterior,
    rng: np.random.Generator,
    *,
    test_id: str,
    service_hours: float | None = None,
    weigh_others: bool = True,
) -> Closed:
    """Join a search and its posteriors to an explanation.

    Parameters
    ----------
    traced : what the search found
    before, after : see `sample_base` and `sample_final`; one where there is no `before`
    rng : for surrogates and refits
    test_id, service_hours : of the test
    weigh_others : held-out evidence of the best candidates that were not added, too
    """
    before = after if before is None else before
    prepared, base, final = traced.prepared, traced.base, traced.final
    held_before = held_out(prepared, base)
    held_after = held_before if final is base else held_out(prepared, final)
    requests = figure_requests(prepared.drive, prepared.operation)
    warnings = tuple(dict.fromkeys((*before.warnings, *after.warnings)))
    found = found_effects(traced, after, held_before, held_after, rng)
    errors_before = error_figures(prepared, before.record_residual, held_before)
    errors_after = error_figures(prepared, after.record_residual, held_after)
    kept = prepared.loop.angle[prepared.kept]
    if found and (remark := remark_on_steps(kept, errors_before.rmse_rad)):
        warnings = (*warnings, remark)
    explanation = Explanation(
        test_id=test_id,
        service_hours=service_hours,
        verdict=_verdict(traced, errors_before, errors_after),
        noise_floor_rad=prepared.noise_floor,
        repeatability_rad=repeatability(
            prepared.record_course, _kept_angle(prepared), prepared.noise_floor
        ),
        outlier_fraction=after.outlier_fraction,
        before=errors_before,
        after=errors_after,
        branch_rmse=branch_rmse(prepared, before.record_residual, after.record_residual),
        carried_by=_carried_by(base, rng),
        effects=found,
        considered=considered(traced, held_before, weigh_others),
        strained=_strained(base),
        parameters_before={name: by_level(before.parameters[name]) for name in NAMES},
        parameters_after={name: by_level(after.parameters[name]) for name in NAMES},
        figures_before={key: by_level(draws) for key, draws in before.figures(requests).items()},
        figures_after={key: by_level(draws) for key, draws in after.figures(requests).items()},
        course=_course(traced, before, after),
        converged=before.converged and after.converged,
        warnings=warnings,
        left_over=traced.left_over,
    )
    return Closed(explanation, before, after)


def remark_on_steps(angle: FloatArray, error: float) -> str | None:
    """Say where what was found may be the pattern of an angle's own steps.

    Steps wider than the noise make errors that follow the angle, which no model of noise expects.

    Parameters
    ----------
    angle : (samples,) as recorded, in rad
    error : root mean square that the drive model alone leaves, in rad
    """
    step = quantisation_step(angle)
    if step is None or step / np.sqrt(12.0) < _OF_STEPS * error:
        return None
    return (
        f"The angle is recorded in steps of {step:.2g} rad, which make up most of the error: what "
        "was found beside the drive model may be their pattern. Believe it where a record with "
        "finer steps shows it, too."
    )


def _kept_angle(prepared: Prepared) -> FloatArray:
    """(samples,) angle with straight lines drawn through the readings that were set aside."""
    at = np.arange(prepared.kept.size)
    return np.asarray(np.interp(at, at[prepared.kept], prepared.loop.angle[prepared.kept]))


def _verdict(traced: Traced, before: ErrorFigures, after: ErrorFigures) -> Verdict:
    final = traced.final
    return verdict_of(
        [*final.ids, *([] if final.term is None else [UNKNOWN])],
        before.rmse_rad,
        after.rmse_rad,
        traced.prepared.noise_floor,
        left_over=traced.left_over is not None,
    )


def _strained(base: Model) -> dict[str, float]:
    far = strained(base.likelihood, base.start)
    return {name: float(abs(away)) for name, away in zip(NAMES, far, strict=True) if away}


def _carried_by(base: Model, rng: np.random.Generator) -> tuple[Carrier, ...]:
    likelihood = base.likelihood
    white = replace(likelihood, noise=likelihood.noise.as_white)
    derivative = white.jacobian(base.start.point)[1]
    ones = 1 / likelihood.noise.white_sd[:, None]
    angle = likelihood.angle(base.start.point[None, :])[0]
    return carriers(
        base.residual / likelihood.noise.white_sd / np.sqrt(base.misfit / likelihood.blocks),
        np.hstack([derivative, ones]),
        angle,
        likelihood.reduced.course,
        rng,
    )


def _course(traced: Traced, before: Posterior, after: Posterior) -> ResidualCourse:
    reduced = traced.base.likelihood.reduced
    likelihood = after.likelihood
    fitted_before = np.median(before.fitted_angles, axis=0)
    fitted_after = np.median(after.fitted_angles, axis=0)
    unknown = None
    added = np.zeros(reduced.angle.size)
    for effect in likelihood.effects:
        whole, absent = after.without_effect(effect.id, EFFECT_DRAWS)
        added += np.median(whole - absent, axis=0)
    if likelihood.noise.term is not None:
        model = traced.final
        left = reduced.angle - likelihood.angle(model.start.point[None, :])[0]
        unknown = likelihood.noise.smooth_part(left - likelihood.offset(left))
        added = added + unknown
    path = reduced.path
    return ResidualCourse(
        torque=path.torque,
        angle=reduced.angle,
        rising=path.direction > 0,
        position=reduced.position,
        time=reduced.time,
        count=reduced.count,
        before=reduced.angle - fitted_before,
        after=reduced.angle - fitted_after,
        added=added - added.mean(),
        unknown=unknown,
        coordinates={**coordinates(reduced.course), "angle": reduced.angle},
        noise=likelihood.noise.white_sd * np.sqrt(traced.final.start.variance),
    )
