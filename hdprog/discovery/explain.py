"""A record before and after: what was added, why, and what it changes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hdprog.discovery.candidates import without
from hdprog.discovery.errors_of_fit import branch_rmse, error_figures
from hdprog.discovery.heldout import HeldOut, elpd_difference, held_out
from hdprog.discovery.model import Model
from hdprog.discovery.pooling import THRESHOLD, share
from hdprog.discovery.residuals import carriers, repeatability
from hdprog.discovery.search import Step, Traced
from hdprog.discovery.separating import indistinguishable, separating_test
from hdprog.explanation import (
    UNKNOWN,
    Carrier,
    ConsideredEffect,
    Explanation,
    FoundEffect,
    ResidualCourse,
    Verdict,
)
from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared
from hdprog.inference.summarise import by_level, figure_requests
from hdprog.inference.until_converged import FULL, QUICK, SamplingPlan
from hdprog.physics.coordinates import coordinates
from hdprog.physics.effects import BY_ID
from hdprog.physics.effects.base import Effect
from hdprog.physics.parameters import NAMES, FloatArray

UNKNOWN_ADVICE = (
    "No mechanism that hdprog knows leaves this trace. Repeat the test: if it comes back, look at "
    "the drawn course for what happens there (a contact, a bearing, the rig's control), and rely "
    "on the figures only as far as their shift allows."
)
# The drive model alone where it misfits: it shows the shift, and many hardly ever mix well.
_BESIDE = replace(QUICK, lengths=25.0, first_steps=100, refits=1, most_steps=2000)
_STRAINED = 2.5  # prior standard deviations
_WIDTH_DRAWS = 200


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
    found = _found(traced, after, held_before, held_after, rng)
    explanation = Explanation(
        test_id=test_id,
        service_hours=service_hours,
        verdict=verdict_of(final),
        noise_floor_rad=prepared.noise_floor,
        repeatability_rad=repeatability(prepared.record_course, prepared.loop.angle),
        outlier_fraction=after.outlier_fraction,
        before=error_figures(prepared, before.record_residual, held_before),
        after=error_figures(prepared, after.record_residual, held_after),
        branch_rmse=branch_rmse(prepared, before.record_residual, after.record_residual),
        carried_by=_carried_by(base, rng),
        effects=found,
        considered=_considered(traced, held_before, weigh_others),
        strained=_strained(base),
        parameters_before={name: by_level(before.parameters[name]) for name in NAMES},
        parameters_after={name: by_level(after.parameters[name]) for name in NAMES},
        figures_before={key: by_level(draws) for key, draws in before.figures(requests).items()},
        figures_after={key: by_level(draws) for key, draws in after.figures(requests).items()},
        course=_course(traced, before, after),
        converged=before.converged and after.converged,
        warnings=warnings,
    )
    return Closed(explanation, before, after)


def verdict_of(final: Model) -> Verdict:
    """The outcome in the words of the contract."""
    if final.term is None:
        return "explained" if final.ids else "adequate"
    return "partly_explained" if final.ids else "unexplained"


def choosing_step(steps: Sequence[Step], chosen: str) -> Step | None:
    """The last forward step that offered an effect while the model lacked it and then took it."""
    for step, following in zip(reversed(steps[:-1]), reversed(steps[1:]), strict=True):
        if chosen in following.before.ids and chosen not in step.before.ids:
            return step
    offered = [step for step in steps if chosen in step.models]
    return offered[-1] if offered else None


def _found(
    traced: Traced,
    after: Posterior,
    held_before: HeldOut,
    held_after: HeldOut,
    rng: np.random.Generator,
) -> tuple[FoundEffect, ...]:
    """Effects of the final model, the one that carries most first."""
    final, found = traced.final, []
    for effect in final.likelihood.effects:
        fewer, held_fewer = traced.base, held_before
        if final.ids != (effect.id,) or final.term is not None:
            fewer = without(final, effect.id, rng)
            held_fewer = held_out(traced.prepared, fewer)
        elpd = elpd_difference(held_after, held_fewer)
        found.append(_mechanism(traced, effect, fewer, after, elpd))
    if final.term is not None:
        found.append(_unknown(traced, held_after))
    return tuple(sorted(found, key=lambda one: (one.id == UNKNOWN, -one.share)))


def _mechanism(
    traced: Traced, effect: Effect, fewer: Model, after: Posterior, elpd: tuple[float, float]
) -> FoundEffect:
    final = traced.final
    step = choosing_step(traced.steps, effect.id)
    others = () if step is None else indistinguishable([step], effect.id)
    others = tuple(name for name in others if name not in final.ids)
    values = after.effect_values[effect.id]
    described = effect.parameters(final.likelihood.reduced.course.scales)
    return FoundEffect(
        id=effect.id,
        words=effect.words,
        coordinate=None,
        log_evidence_gain=final.log_evidence - fewer.log_evidence,
        elpd_gain=elpd[0],
        elpd_se=elpd[1],
        share=share([traced.base], [fewer], [final]),
        parameters={one.name: by_level(values[one.name][:, 0]) for one in described},
        units={one.name: one.unit for one in described},
        indistinguishable_from=others,
        separating_test=separating_test({effect.id, *others}),
        advice=effect.advice,
    )


def _unknown(traced: Traced, held_after: HeldOut) -> FoundEffect:
    final = traced.final
    fewer = traced.mechanisms if final.ids else traced.base
    gain, error = elpd_difference(held_after, held_out(traced.prepared, fewer))
    term = final.term
    assert term is not None
    return FoundEffect(
        id=UNKNOWN,
        words="an effect that no known mechanism describes",
        coordinate=term.coordinate,
        log_evidence_gain=final.log_evidence - fewer.log_evidence,
        elpd_gain=gain,
        elpd_se=error,
        share=share([traced.base], [fewer], [final]),
        parameters={},
        units={},
        indistinguishable_from=(),
        separating_test=None,
        advice=UNKNOWN_ADVICE,
    )


def _considered(traced: Traced, held_before: HeldOut, weigh: bool) -> tuple[ConsideredEffect, ...]:
    """What was looked at and not added, best first, then what the record cannot show."""
    first = traced.steps[0]
    gains = first.gains
    looked_at: list[ConsideredEffect] = []
    for rank, name in enumerate(sorted(gains, key=lambda name: -gains[name])):
        if name in traced.final.ids:
            continue
        gain, error = None, None
        if weigh and rank < 3 and gains[name] > 0:
            held = held_out(traced.prepared, first.models[name])
            gain, error = elpd_difference(held, held_before)
        why_not = _why_not(traced, name)
        looked_at.append(
            ConsideredEffect(name, BY_ID[name].words, gains[name], gain, error, why_not)
        )
    lacking = [
        ConsideredEffect(
            name,
            BY_ID[name].words,
            None,
            None,
            None,
            f"cannot be told from this record: it lacks {' and '.join(needs)}",
        )
        for name, needs in traced.missing.items()
    ]
    return (*looked_at, *lacking)


def _why_not(traced: Traced, name: str) -> str:
    gain = traced.steps[0].gains[name]
    final = traced.final
    if gain < THRESHOLD:
        return f"no evidence: log Bayes factor {_told(gain)} where {THRESHOLD:g} is asked for"
    if name in traced.mechanisms.ids:
        return (
            "carries part of the error only; an empirical term carries more of it, so the "
            "mechanism is not believed"
        )
    if final.ids:
        best = max(traced.steps[0].gains[one] for one in final.ids if one in traced.steps[0].gains)
        last = next(
            (step.gains[name] for step in reversed(traced.steps) if name in step.models), gain
        )
        beside = " + ".join(one.replace("_", " ") for one in final.ids)
        if len(traced.steps) > 1 and last < THRESHOLD:
            return (
                f"log Bayes factor {_told(gain)} where {best:.1f} was reached; beside {beside} it "
                f"gains nothing more ({_told(last)})"
            )
        return (
            f"log Bayes factor {_told(last)} beside {beside}, but it would carry too little of the "
            "error"
        )
    return f"log Bayes factor {_told(gain)}, less than an empirical term gains"


def _told(gain: float) -> str:
    """To one decimal, and no minus before a zero."""
    return f"{round(gain, 1) + 0.0:.1f}"


def _strained(base: Model) -> dict[str, float]:
    likelihood = base.likelihood
    away = (base.start.point - likelihood.prior_mean) / likelihood.prior_sd
    return {
        name: float(abs(away[index]))
        for index, name in enumerate(NAMES)
        if abs(away[index]) > _STRAINED
    }


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
        whole, absent = after.without_effect(effect.id, _WIDTH_DRAWS)
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


def effect_size(posterior: Posterior, effect_id: str) -> FloatArray:
    """(draws,) root mean square over the record of what an effect moves the angle by, in rad."""
    whole, absent = posterior.without_effect(effect_id, _WIDTH_DRAWS)
    change = whole - absent
    return np.asarray((change - change.mean(axis=1, keepdims=True)).std(axis=1))
