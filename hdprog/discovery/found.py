"""Each effect of a final model: what it gains, carries, and cannot be told from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.discovery.candidates import without
from hdprog.discovery.forward_step import Step
from hdprog.discovery.heldout import HeldOut, elpd_difference, held_out
from hdprog.discovery.model import Model, gain_over
from hdprog.discovery.pooling import share
from hdprog.discovery.search import Traced
from hdprog.discovery.separating import indistinguishable, separating_test
from hdprog.discovery.unknown import TERM_PENALTY, TermGain, with_term
from hdprog.explanation import UNKNOWN, FoundEffect
from hdprog.inference.posterior import Posterior
from hdprog.physics.effects.base import Effect
from hdprog.physics.parameters import FloatArray
from hdprog.results import by_level

UNKNOWN_ADVICE = (
    "No mechanism that hdprog knows leaves this trace. Repeat the test: if it comes back, look at "
    "the drawn course for what happens there (a contact, a bearing, the rig's control), and rely "
    "on the figures only as far as their shift allows."
)
EFFECT_DRAWS = 200
"""Of a posterior, from which what an effect moves is told."""


def found_effects(
    traced: Traced,
    after: Posterior,
    held_before: HeldOut,
    held_after: HeldOut,
    rng: np.random.Generator,
) -> tuple[FoundEffect, ...]:
    """Effects of the final model, the one that carries most first.

    Parameters
    ----------
    traced : what the search found
    after : posterior of the final model
    held_before, held_after : what held-out data say of the models before and after
    rng : for refits without one of several effects
    """
    final, found = traced.final, []
    for effect in final.likelihood.effects:
        fewer, held_fewer = traced.base, held_before
        if final.ids != (effect.id,) or final.term is not None:
            fewer = _without(final, effect.id, rng)
            held_fewer = held_out(traced.prepared, fewer)
        elpd = elpd_difference(held_after, held_fewer)
        found.append(_mechanism(traced, effect, fewer, after, elpd))
    if final.term is not None:
        found.append(_unknown(traced, held_after))
    return tuple(sorted(found, key=lambda one: (one.id == UNKNOWN, -one.share)))


def _without(final: Model, removed: str, rng: np.random.Generator) -> Model:
    """The final model with an effect taken out, and the empirical term, if any, kept."""
    fewer = without(final, removed, rng)
    if final.term is None:
        return fewer
    beside_white = final.likelihood.noise.log_ratio is None
    return with_term(fewer, TermGain(final.term.coordinate, 0.0, beside_white), rng)


def _mechanism(
    traced: Traced, effect: Effect, fewer: Model, after: Posterior, elpd: tuple[float, float]
) -> FoundEffect:
    final = traced.final
    step = choosing_step(traced.steps, effect.id)
    others = () if step is None else indistinguishable([step], effect.id)
    others = tuple(name for name in others if name not in final.ids)
    values = after.effect_values[effect.id]
    described = effect.told_parameters(final.likelihood.reduced.course.scales)
    return FoundEffect(
        id=effect.id,
        words=effect.words,
        coordinate=None,
        log_evidence_gain=gain_over(fewer, final),
        elpd_gain=elpd[0],
        elpd_se=elpd[1],
        share=share([traced.base], [fewer], [final]),
        parameters={one.name: by_level(values[one.name][:, 0]) for one in described},
        units={one.name: one.unit for one in described},
        indistinguishable_from=others,
        separating_test=separating_test({effect.id, *others}),
        advice=advice_on(effect, [] if step is None else [step]),
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
        log_evidence_gain=gain_over(fewer, final) - TERM_PENALTY,
        elpd_gain=gain,
        elpd_se=error,
        share=share([traced.base], [fewer], [final]),
        parameters={},
        units={},
        indistinguishable_from=(),
        separating_test=None,
        advice=UNKNOWN_ADVICE,
    )


def advice_on(effect: Effect, steps: Sequence[Step]) -> str:
    """What to do about an effect: less where the records do not rule its rivals out.

    Parameters
    ----------
    effect : that was found
    steps : the forward step that chose it, of each record that has it
    """
    shown = {name for step in steps for name in step.models}
    as_good = set(indistinguishable(steps, effect.id)) if steps else set()
    told = effect.rivals <= shown - as_good
    return effect.advice if told else effect.unsure_advice


def choosing_step(steps: Sequence[Step], chosen: str) -> Step | None:
    """The last forward step that offered an effect while the model lacked it and then took it."""
    for step, following in zip(reversed(steps[:-1]), reversed(steps[1:]), strict=True):
        if chosen in following.before.ids and chosen not in step.before.ids:
            return step
    offered = [step for step in steps if chosen in step.models]
    return offered[-1] if offered else None


def effect_size(posterior: Posterior, effect_id: str) -> FloatArray:
    """(draws,) root mean square over the record of what an effect moves the angle by, in rad."""
    whole, absent = posterior.without_effect(effect_id, EFFECT_DRAWS)
    change = whole - absent
    return np.asarray((change - change.mean(axis=1, keepdims=True)).std(axis=1))
