"""One forward step of the search: every candidate effect, and every empirical term, on a model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hdprog.discovery.candidates import refits, refits_again
from hdprog.discovery.model import Model, gain_over
from hdprog.discovery.pooling import THRESHOLD, pooled
from hdprog.discovery.unknown import TermGain, term_gains
from hdprog.physics.effects.base import Effect

_STRUCTURE = 2.0  # log evidence below which nothing is worth a thorough search
_PROMISING = 4  # candidates that are searched thoroughly where one leads clearly
_OUT_OF_REACH = 0.5  # log evidence below which a thorough search has not lifted any to the fore
_RIVAL = 0.75  # of the leader's pooled evidence: a thorough search lifts others by less than that
_SEVERAL = 3  # records that do not all miss an effect's best mode


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
        return {name: gain_over(self.before, model) for name, model in self.models.items()}


def forward_steps(
    models: Sequence[Model],
    offered: Sequence[Sequence[Effect]],
    made: Sequence[Step],
    rngs: Sequence[np.random.Generator],
    spread: Callable[..., Iterable[Any]],
    inner: Callable[..., Iterable[Any]] | None,
) -> list[Step]:
    """One step on every record.

    A record that does not show the effect that was added last keeps its model, and then what the
    last step found on it.

    Parameters
    ----------
    models : so far, one a record
    offered : candidates on each record
    made : the last steps; none at first
    rngs : one a record
    spread : map over the records
    inner : map over the candidates of a record instead, where there is one record
    """
    steps: list[Step | None] = [None] * len(models)
    for at, last in enumerate(made):
        if last.before is models[at] and all(one.id in last.models for one in offered[at]):
            left = {one.id: last.models[one.id] for one in offered[at]}
            steps[at] = replace(last, models=left)
    to_do = [at for at, step in enumerate(steps) if step is None]
    # Where the candidates are spread, the records go one after the other.
    over = spread if inner is None else map
    within = [map if inner is None else inner] * len(to_do)
    begun, effects = [models[at] for at in to_do], [offered[at] for at in to_do]
    looks = list(over(_first_look, begun, effects, within))
    again = [
        {name: look.models[name] for name in chosen}
        for look, chosen in zip(looks, _promising(looks), strict=True)
    ]
    found = over(refits_again, begun, again, [rngs[at] for at in to_do], within)
    for at, look, better in zip(to_do, looks, found, strict=True):
        # The caller's own model: what comes back from another process is a copy of it.
        steps[at] = replace(look, before=models[at], models={**look.models, **better})
    return [step for step in steps if step is not None]


def _first_look(
    model: Model, effects: Sequence[Effect], spread: Callable[..., Iterable[Any]]
) -> Step:
    return Step(model, refits(model, effects, spread), term_gains(model))


def _promising(looks: Sequence[Step]) -> list[list[str]]:
    """The candidates of each record that are worth a thorough search."""
    each = [look.gains for look in looks]
    rivals = _rivals(looks, each) if len(looks) >= _SEVERAL else None
    chosen = []
    for look, gains in zip(looks, each, strict=True):
        leading = sorted(gains, key=lambda name: -gains[name])
        best = max(gains.values(), default=0.0)
        empirical = max(term.gain for term in look.terms.values())
        # Where one candidate does as well as a free function, few others need a second look.
        clear = best > max(empirical, THRESHOLD)
        leading = leading[: _PROMISING if clear else 2 * _PROMISING]
        if max(best, empirical) <= _STRUCTURE:
            leading = []
        if rivals is not None:
            leading = [name for name in leading if name in rivals]
        chosen.append([name for name in leading if gains[name] > _OUT_OF_REACH])
    return chosen


def _rivals(looks: Sequence[Step], each: Sequence[Mapping[str, float]]) -> set[str] | None:
    """The candidates that may be best over all records; None where none leads clearly.

    Parameters
    ----------
    looks : one a record
    each : gain of every candidate of each record
    """
    names = set().union(*each)
    over_all = {name: pooled([own[name] for own in each if name in own]) for name in names}
    best = max(over_all.values(), default=0.0)
    coordinates = set.intersection(*(set(look.terms) for look in looks))
    free = max(pooled([look.terms[name].gain for look in looks]) for name in coordinates)
    if best <= max(free, THRESHOLD):
        return None
    return {name for name, gain in over_all.items() if gain > _RIVAL * best}
