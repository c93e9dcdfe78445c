"""Stepwise search for what the drive model lacks on one record or on the tests of one drive.

Forward with a backward check: a mechanism is added while it gains enough log evidence over all
tests together and carries a fair share of what the drive model leaves. What no mechanism carries
is an empirical term over the coordinate that carries it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hdprog.discovery.candidates import refits, refits_again, without
from hdprog.discovery.model import Model
from hdprog.discovery.unknown import TermGain, term_gains, with_term
from hdprog.inference.effect_starts import unmet
from hdprog.inference.prepare import Prepared, settle_noise
from hdprog.physics.effects import EFFECTS
from hdprog.physics.effects.base import Effect

THRESHOLD = 5.0
"""Log evidence that an effect must gain. Rates on simulated loops: tests/benchmarks/effects."""
TERM_THRESHOLD = 5.0
"""Log evidence that an empirical term must gain."""
TIME_THRESHOLD = 14.0
"""The same for a term over time or order, which correlated noise looks like."""
FURTHER_SHARE = 0.10
"""Share of the explained error that a second or later mechanism must carry."""
CLEARING_SHARE = 0.02
"""The same for one that clears up what the others left: to less than a quarter of it."""
UNKNOWN_SHARE = 0.08
"""Share of the explained error that an empirical term must carry beside mechanisms."""
NAMED_SHARE = 0.75
"""Share of the explainable error below which mechanisms give way to an empirical term."""
_CLEARED = 0.25
_MOST_EFFECTS = 4
_MOST_STEPS = 7
_LIKE_NOISE = ("time", "order")
_STRUCTURE = 2.0  # log evidence below which nothing is worth a thorough search
_PROMISING = 4  # candidates that are searched thoroughly where one leads clearly
_OUT_OF_REACH = 0.5  # log evidence below which a thorough search has not lifted any to the fore


@dataclass(frozen=True)
class Step:
    """One forward step on one record.

    Attributes
    ----------
    before : model that candidates were added to
    models : the refitted candidates by id
    terms : empirical terms by coordinate
    """

    before: Model
    models: Mapping[str, Model]
    terms: Mapping[str, TermGain]

    @property
    def gains(self) -> Mapping[str, float]:
        """Gain of log evidence of each candidate."""
        return {
            name: model.log_evidence - self.before.log_evidence
            for name, model in self.models.items()
        }


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
    """

    prepared: Prepared
    base: Model
    final: Model
    mechanisms: Model
    steps: tuple[Step, ...]
    missing: Mapping[str, tuple[str, ...]]


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
    rngs = [np.random.default_rng(seed) for seed in seeds]
    bases: list[Model] = list(spread(base_model, records, rngs))
    models = list(bases)
    missing = [
        {effect.id: unmet(effect, record.likelihood.reduced.course) for effect in effects}
        for record in records
    ]
    steps: list[list[Step]] = [[] for _ in records]
    taken: list[str] = []
    remaining: list[Mapping[str, TermGain]] | None = None
    for _ in range(_MOST_STEPS):
        offered = [
            [effect for effect in effects if effect.id not in taken and not lacking[effect.id]]
            for lacking in missing
        ]
        if inner is not None:
            now = [_step(*job, inner) for job in zip(models, offered, rngs, strict=True)]
        else:
            now = list(spread(_step, models, offered, rngs))
        chosen = _choose(now, bases, further=bool(taken))
        if chosen is not None:
            now = _fairly(now, chosen, rngs)
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
        models = [_joined(step, chosen) for step in now]
        taken.append(chosen)
        if len(taken) == _MOST_EFFECTS:
            break
        models, taken = _checked_back(models, bases, taken, rngs)
    finals = _with_unknown(bases, models, remaining)
    return tuple(
        Traced(
            prepared=record,
            base=base,
            final=final,
            mechanisms=model,
            steps=tuple(record_steps),
            missing={name: needs for name, needs in lacking.items() if needs},
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


def pooled(gains: Sequence[float]) -> float:
    """Log evidence of "some tests have it" over "none has it", each as likely as not."""
    if len(gains) == 1:
        return gains[0]
    return float(np.sum(np.logaddexp(0.0, gains) - np.log(2.0)))


def share(bases: Sequence[Model], before: Sequence[Model], after: Sequence[Model]) -> float:
    """Share of the error explained by `after` that it explains and `before` does not."""
    return _share(*(sum(model.misfit for model in many) for many in (bases, before, after)))


def _share(base: float, before: float, after: float) -> float:
    return float(np.clip((before - after) / (base - after), -1.0, 1.0)) if base > after else 0.0


def _carries(bases: Sequence[Model], before: Sequence[Model], after: Sequence[Model]) -> bool:
    """Whether what `after` has over `before` is more than the leftover of another shape.

    Misfits beside white noise: what correlated noise takes over would count for the first effect.
    """
    base, left, right = (
        sum(model.least_misfit for model in many) for many in (bases, before, after)
    )
    wanted = CLEARING_SHARE if right < _CLEARED * left else FURTHER_SHARE
    return _share(base, left, right) >= wanted


def _step(
    model: Model,
    effects: Sequence[Effect],
    rng: np.random.Generator,
    spread: Callable[..., Iterable[Any]] = map,
) -> Step:
    models = dict(refits(model, effects, spread=spread))
    terms = term_gains(model)
    gains = {name: found.log_evidence - model.log_evidence for name, found in models.items()}
    best, empirical = max(gains.values()), max(term.gain for term in terms.values())
    if max(best, empirical) > _STRUCTURE:
        # Where one candidate does as well as a free function, few others need a second look.
        leading = sorted(gains, key=lambda name: -gains[name])
        clear = best > max(empirical, THRESHOLD)
        leading = leading[: _PROMISING if clear else 2 * _PROMISING]
        again = {name: models[name] for name in leading if gains[name] > _OUT_OF_REACH}
        for name, found in refits_again(model, again, rng, spread=spread).items():
            models[name] = max(models[name], found, key=lambda one: one.log_evidence)
    return Step(model, models, terms)


def _fairly(steps: Sequence[Step], chosen: str, rngs: Sequence[np.random.Generator]) -> list[Step]:
    """The steps with the simpler models refitted from where the chosen effect led.

    A candidate starts from more places than the model it is held against, and may owe its gain to
    a mode that this one has as well.
    """
    again = []
    for step, rng in zip(steps, rngs, strict=True):
        joined = _joined(step, chosen)
        if joined is not step.before:
            fewer = without(joined, chosen, rng)
            if fewer.log_evidence > step.before.log_evidence:
                step = replace(step, before=fewer)
        again.append(step)
    return again


def _joined(step: Step, name: str) -> Model:
    """The model with an effect where the record shows it."""
    return step.models[name] if step.gains.get(name, -1.0) > 0 else step.before


def _choose(steps: Sequence[Step], bases: Sequence[Model], *, further: bool) -> str | None:
    names = {name for step in steps for name in step.models}
    gains = {
        name: pooled([step.gains[name] for step in steps if name in step.models]) for name in names
    }
    best = max(sorted(gains), key=lambda name: gains[name])
    before, after = [step.before for step in steps], [_joined(step, best) for step in steps]
    if gains[best] < THRESHOLD or (further and not _carries(bases, before, after)):
        return None
    return best


def _checked_back(
    models: list[Model],
    bases: Sequence[Model],
    taken: list[str],
    rngs: Sequence[np.random.Generator],
) -> tuple[list[Model], list[str]]:
    """Take out what a later effect made needless."""
    for name in taken[:-1]:
        fewer = [
            without(model, name, rng) if name in model.ids else model
            for model, rng in zip(models, rngs, strict=True)
        ]
        lost = pooled(
            [one.log_evidence - two.log_evidence for one, two in zip(models, fewer, strict=True)]
        )
        if lost < THRESHOLD or not _carries(bases, fewer, models):
            models, taken = fewer, [one for one in taken if one != name]
    return models, taken


def _with_unknown(
    bases: Sequence[Model],
    models: Sequence[Model],
    remaining: Sequence[Mapping[str, TermGain]] | None,
) -> list[Model]:
    """Add an empirical term where structure remains, or put it in the mechanisms' place.

    `remaining` are the terms over `models`, where the last step has found them already.
    """
    remaining = [term_gains(model) for model in models] if remaining is None else remaining
    best, gain = _best_term(remaining)
    if not any(model.ids for model in models):
        return _with_term(models, remaining, best) if gain > 0 else list(bases)
    wider = _with_term(models, remaining, best)
    own = [term_gains(model) for model in bases]
    best_alone, alone_gain = _best_term(own)
    alone = _with_term(bases, own, best_alone)
    floor = min(sum(model.misfit for model in many) for many in (wider, alone))
    base, left = sum(model.misfit for model in bases), sum(model.misfit for model in models)
    evidence = sum(
        one.log_evidence - other.log_evidence for one, other in zip(models, alone, strict=True)
    )
    poorly = (base - left) < NAMED_SHARE * (base - floor)
    beaten = evidence < -THRESHOLD and left > sum(model.misfit for model in alone)
    if alone_gain > 0 and (beaten or (poorly and evidence < 0)):
        return alone
    if gain > 0 and share(bases, models, wider) > UNKNOWN_SHARE:
        return wider
    return list(models)


def _best_term(terms: Sequence[Mapping[str, TermGain]]) -> tuple[str, float]:
    """Coordinate whose empirical term gains most, and by how much that is above its threshold."""
    names = set.intersection(*(set(found) for found in terms))
    gains = {
        name: pooled([found[name].gain for found in terms])
        - (TIME_THRESHOLD if name in _LIKE_NOISE else TERM_THRESHOLD)
        for name in sorted(names)
    }
    best = max(gains, key=lambda name: gains[name])
    return best, gains[best]


def _with_term(
    models: Sequence[Model], terms: Sequence[Mapping[str, TermGain]], coordinate: str
) -> list[Model]:
    """The models with the empirical term over a coordinate, where it gains anything."""
    return [
        with_term(model, found[coordinate])
        if found[coordinate].gain > 0 or len(models) == 1
        else model
        for model, found in zip(models, terms, strict=True)
    ]
