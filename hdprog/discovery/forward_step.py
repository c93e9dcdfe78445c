"""One forward step of the search: every candidate effect, and every empirical term, on a model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hdprog.discovery.candidates import refits, refits_again
from hdprog.discovery.model import Model
from hdprog.discovery.pooling import THRESHOLD
from hdprog.discovery.unknown import TermGain, term_gains
from hdprog.physics.effects.base import Effect

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
    jobs = ([models[at] for at in to_do], [offered[at] for at in to_do], [rngs[at] for at in to_do])
    if inner is None:
        done = list(spread(_step, *jobs))
    else:
        done = [_step(*job, spread=inner) for job in zip(*jobs, strict=True)]
    for at, step in zip(to_do, done, strict=True):
        steps[at] = step
    return [step for step in steps if step is not None]


def _step(
    model: Model,
    effects: Sequence[Effect],
    rng: np.random.Generator,
    spread: Callable[..., Iterable[Any]] = map,
) -> Step:
    models = dict(refits(model, effects, spread=spread))
    terms = term_gains(model)
    gains = {name: found.log_evidence - model.log_evidence for name, found in models.items()}
    best = max(gains.values(), default=0.0)
    empirical = max(term.gain for term in terms.values())
    if max(best, empirical) > _STRUCTURE:
        # Where one candidate does as well as a free function, few others need a second look.
        leading = sorted(gains, key=lambda name: -gains[name])
        clear = best > max(empirical, THRESHOLD)
        leading = leading[: _PROMISING if clear else 2 * _PROMISING]
        again = {name: models[name] for name in leading if gains[name] > _OUT_OF_REACH}
        for name, found in refits_again(model, again, rng, spread=spread).items():
            models[name] = max(models[name], found, key=lambda one: one.log_evidence)
    return Step(model, models, terms)
