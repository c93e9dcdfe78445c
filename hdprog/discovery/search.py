"""Stepwise search for what the drive model lacks on one record or on the tests of one drive.

Forward with a backward check: a mechanism is added while it gains enough log evidence over all
tests together and carries a fair share of what the drive model leaves. What no mechanism carries
is an empirical term over the coordinate that carries it.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hdprog.discovery.candidates import refit_like, without
from hdprog.discovery.empirical import over_threshold, strongest, with_unknown
from hdprog.discovery.forward_step import Step, forward_steps
from hdprog.discovery.model import Model
from hdprog.discovery.pooling import THRESHOLD, children, refitted, share_of
from hdprog.discovery.sharing import gain_of_steps, gain_together
from hdprog.discovery.unknown import TermGain, term_gains
from hdprog.explanation import UNKNOWN, LeftOver
from hdprog.inference.effect_starts import unmet
from hdprog.inference.prepare import Prepared, settle_noise
from hdprog.physics.effects import EFFECTS
from hdprog.physics.effects.base import Effect

FURTHER_SHARE = 0.10
"""Share of the explained error that a second or later mechanism must carry."""
CLEARING_SHARE = 0.08
"""The same for one that clears up what the others left, times the part of that which it leaves.

Of a first effect in another shape hardly any other clears up the leftover; what clears it up all
the better may be the smaller beside a large first one.
"""
_CLEARED = 0.25  # the largest such part
CLEAR_EVIDENCE = 25.0
"""Log evidence from which a further mechanism needs no share, where it leaves noise alone.

What another shape of the first one leaves is followed by a curve as well as by a mechanism, and
hardly ever down to the noise where it is so clear.
"""
LEFT_OVER_EVIDENCE = 10.0
"""Log evidence of what is refused for its share alone from which it is said that it remains.

Of a curve over time or order so much more as its threshold is higher.
"""
_NOISE = 1.1  # mean square of what is left over the noise's, up to which it is noise alone
_RIVAL = 0.75  # of its gain that no other mechanism reaches: a leftover is followed by several
_MOST_EFFECTS = 4
_MOST_STEPS = 7


@dataclass(frozen=True)
class _Choice:
    """An effect to add: to every record that may show it, or to those that do."""

    name: str
    common: bool

    def joined(self, step: Step) -> Model:
        """The record's model with the effect."""
        if self.name not in step.models:
            return step.before
        shown = self.common or step.gains[self.name] > 0
        return step.models[self.name] if shown else step.before


@dataclass(frozen=True)
class Traced:
    """What a search found on one record.

    Attributes
    ----------
    prepared : the record
    base, final : models before and after
    mechanisms : the mechanisms alone, be they in `final` or rejected for an empirical term
    steps : forward steps; the last one added nothing, unless the bound was reached
    missing : id → what the record lacks, for effects that it cannot show
    left_over : what was refused beside the mechanisms for its share alone, if it is beyond doubt
    """

    prepared: Prepared
    base: Model
    final: Model
    mechanisms: Model
    steps: tuple[Step, ...]
    missing: Mapping[str, tuple[str, ...]]
    left_over: LeftOver | None = None


def trace(
    records: Sequence[Prepared],
    seeds: Sequence[np.random.SeedSequence],
    effects: Sequence[Effect] = EFFECTS,
    spread: Callable[..., Iterable[Any]] = map,
    inner: Callable[..., Iterable[Any]] | None = None,
) -> tuple[Traced, ...]:
    """Find the effects that the drive model lacks, by the evidence of all records together.

    A record takes part in an effect that it shows; one that grows with wear may be absent at first.

    Parameters
    ----------
    records : one, or the tests of one drive
    seeds : of the searches, one a record
    effects : candidates
    spread : map over the records, e.g. an executor's
    inner : map over the candidates of a record instead, where there is one record

    Returns
    -------
    one a record
    """
    # Copies: a seed sequence counts its children, and the caller's would not begin anew.
    rngs = [np.random.default_rng(copy.copy(seed)) for seed in seeds]
    bases: list[Model] = list(spread(base_model, records, children(rngs)))
    models = list(bases)
    missing = [
        {effect.id: unmet(effect, record.likelihood.reduced.course) for effect in effects}
        for record in records
    ]
    steps: list[list[Step]] = [[] for _ in records]
    taken: list[str] = []
    made: list[Step] = []
    remaining: list[Mapping[str, TermGain]] | None = None
    for _ in range(_MOST_STEPS):
        offered = [
            [effect for effect in effects if effect.id not in taken and not lacking[effect.id]]
            for lacking in missing
        ]
        now = made = forward_steps(models, offered, made, children(rngs), spread, inner)
        chosen = _choose(now, bases, further=bool(taken))
        if chosen is not None:
            now = _alike(now, chosen, rngs, spread)
            now = _fairly(now, chosen, children(rngs), spread)
            if not taken:
                bases = [step.before for step in now]
            models = [step.before for step in now]
        for record_steps, step in zip(steps, now, strict=True):
            record_steps.append(step)
        if chosen is None:
            remaining = [step.terms for step in now]
            break
        if _choose(now, bases, further=bool(taken)) is None:
            continue
        models = [chosen.joined(step) for step in now]
        taken.append(chosen.name)
        models, taken = _checked_back(models, bases, taken, rngs, spread)
        if len(taken) == _MOST_EFFECTS:
            break
    finals = with_unknown(bases, models, remaining, rngs, spread)
    left_over = None if remaining is None else _left_over(made, remaining)
    if remaining is not None and _gave_way(models, finals) and (small := _leading(made)):
        # A free curve may be needed only for what one more mechanism carries.
        more = [small.joined(step) for step in _alike(made, small, rngs, spread)]
        others = with_unknown(bases, more, None, rngs, spread)
        if not _gave_way(more, others):
            models, finals, left_over = more, others, None
    return tuple(
        Traced(
            prepared=record,
            base=base,
            final=final,
            mechanisms=model,
            steps=tuple(record_steps),
            missing={name: needs for name, needs in lacking.items() if needs},
            left_over=left_over if final is model and model.ids else None,
        )
        for record, base, final, model, record_steps, lacking in zip(
            records, bases, finals, models, steps, missing, strict=True
        )
    )


def base_model(prepared: Prepared, rng: np.random.Generator) -> Model:
    """The drive model alone, its noise white or correlated, whichever the record asks for."""
    white = Model(prepared.likelihood, tuple(prepared.starts))
    likelihood, starts = settle_noise(prepared.likelihood, prepared.starts, rng)
    other = Model(likelihood, tuple(starts))
    return max((white, other), key=lambda model: model.log_evidence)


def _carries(bases: Sequence[Model], before: Sequence[Model], after: Sequence[Model]) -> bool:
    """Whether what `after` has over `before` is more than the leftover of another shape.

    Misfits beside white noise: what correlated noise takes over would count for the first effect.
    """
    base, left, right = (
        sum(model.least_misfit for model in many) for many in (bases, before, after)
    )
    wanted = CLEARING_SHARE * right / left if right < _CLEARED * left else FURTHER_SHARE
    return share_of(base, left, right) >= wanted


def _believed(
    bases: Sequence[Model], before: Sequence[Model], after: Sequence[Model], gain: float
) -> bool:
    """Whether a further mechanism is no leftover: by its share, or by what it leaves."""
    return _carries(bases, before, after) or _clears(before, after, gain)


def _clears(before: Sequence[Model], after: Sequence[Model], gain: float) -> bool:
    """Whether a mechanism that gains so much leaves noise alone, and no curve gains as much.

    A first effect may be so large that the share of every other one is small.
    """
    left = sum(model.least_misfit for model in after)
    if gain < CLEAR_EVIDENCE or left > _NOISE * sum(model.likelihood.blocks for model in after):
        return False
    curve, still = (over_threshold([term_gains(one) for one in many]) for many in (before, after))
    return still <= 0 and gain - THRESHOLD > curve


def _alike(
    steps: Sequence[Step],
    choice: _Choice,
    rngs: Sequence[np.random.Generator],
    spread: Callable[..., Iterable[Any]],
) -> list[Step]:
    """The steps with an effect refitted from where it is seen best.

    A record that hardly shows it by itself may have settled on another shape, or on drive
    parameters that stand in for it.
    """
    name = choice.name
    before = [step.before for step in steps]
    found = [step.models.get(name, step.before) for step in steps]
    shown = [at for at, step in enumerate(steps) if name in step.models]
    best = max(shown, key=lambda at: steps[at].gains[name])
    others = [at for at in shown if at != best]
    if not others:
        return list(steps)
    like, own = [found[best]] * len(steps), children(rngs)
    found = refitted(found, others, spread, refit_like, before, like, own)
    return [
        replace(step, models={**step.models, name: one}) if name in step.models else step
        for step, one in zip(steps, found, strict=True)
    ]


def _fairly(
    steps: Sequence[Step],
    chosen: _Choice,
    rngs: Sequence[np.random.Generator],
    spread: Callable[..., Iterable[Any]],
) -> list[Step]:
    """The steps with the simpler models refitted from where the chosen effect led.

    A candidate starts from more places than the model it is held against, and may owe its gain to
    a mode that this one has as well.
    """
    joined = [chosen.joined(step) for step in steps]
    fewer = _without(joined, chosen.name, rngs, spread)
    return [
        replace(step, before=one) if one.log_evidence > step.before.log_evidence else step
        for step, one in zip(steps, fewer, strict=True)
    ]


def _without(
    models: Sequence[Model],
    name: str,
    rngs: Sequence[np.random.Generator],
    spread: Callable[..., Iterable[Any]],
) -> list[Model]:
    """The models with an effect taken out where they have it."""
    having = [at for at, model in enumerate(models) if name in model.ids]
    return refitted(models, having, spread, without, [name] * len(models), rngs)


def _leading(steps: Sequence[Step]) -> _Choice | None:
    """The effect that gains most, if that is enough."""
    names = sorted({name for step in steps for name in step.models})
    if not names:
        return None
    gains = {name: gain_of_steps(name, steps) for name in names}
    best = max(names, key=lambda name: gains[name][0])
    gain, common = gains[best]
    return _Choice(best, common) if gain >= THRESHOLD else None


def _choose(steps: Sequence[Step], bases: Sequence[Model], *, further: bool) -> _Choice | None:
    """The leading effect, unless it is a further one and carries too little."""
    choice = _leading(steps)
    if choice is None or not further:
        return choice
    before, after = [step.before for step in steps], [choice.joined(step) for step in steps]
    gain, _ = gain_of_steps(choice.name, steps)
    others = {name for step in steps for name in step.models} - {choice.name}
    rival = max((gain_of_steps(name, steps)[0] for name in others), default=0.0)
    alone = gain if rival < _RIVAL * gain else 0.0
    return choice if _believed(bases, before, after, alone) else None


def _left_over(steps: Sequence[Step], terms: Sequence[Mapping[str, TermGain]]) -> LeftOver | None:
    """The mechanism or the curve that gains most on the last models, if no chance does as well."""
    name, gain, over = strongest(terms)
    found = LeftOver(UNKNOWN, name, gain)
    if (leading := _leading(steps)) is not None:
        gain, _ = gain_of_steps(leading.name, steps)
        # By what each gains over its own threshold: a curve over time must gain more.
        if gain - THRESHOLD >= over:
            found, over = LeftOver(leading.name, None, gain), gain - THRESHOLD
    return found if over >= LEFT_OVER_EVIDENCE - THRESHOLD else None


def _gave_way(models: Sequence[Model], finals: Sequence[Model]) -> bool:
    """Whether mechanisms were given up for an empirical term."""
    return any(model.ids for model in models) and not any(model.ids for model in finals)


def _checked_back(
    models: list[Model],
    bases: Sequence[Model],
    taken: list[str],
    rngs: Sequence[np.random.Generator],
    spread: Callable[..., Iterable[Any]],
) -> tuple[list[Model], list[str]]:
    """Take out what a later effect made needless."""
    for name in taken[:-1]:
        fewer = _without(models, name, children(rngs), spread)
        having = [one if name in one.ids else None for one in models]
        lost, _ = gain_together(name, fewer, having)
        if lost < THRESHOLD or not _believed(bases, fewer, models, lost):
            models, taken = fewer, [one for one in taken if one != name]
    return models, taken
