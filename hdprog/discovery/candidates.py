"""Which mechanism: candidates refitted fully on top of a model, several starts each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hdprog.discovery.model import Model, settled
from hdprog.discovery.reach import within_reach
from hdprog.inference.effect_starts import effect_starts, search_widely
from hdprog.inference.likelihood import COUNT
from hdprog.inference.starting_points import descend_all, describe, starting_points
from hdprog.physics.effects.base import Effect

_WORTH_SETTLING = 1.0  # log evidence gained beside white noise; below it no other noise helps


def refits(
    model: Model,
    effects: Sequence[Effect],
    spread: Callable[..., Iterable[Any]] = map,
) -> Mapping[str, Model]:
    """The model with each effect added in turn, its noise found anew; by the effect's id.

    Parameters
    ----------
    model : to add to
    effects : candidates that the record can show
    spread : map over the candidates, e.g. an executor's
    """
    found = spread(_refit, [_beside(model)] * len(effects), effects)
    return {effect.id: refitted for effect, refitted in zip(effects, found, strict=True)}


def refits_again(
    model: Model,
    candidates: Mapping[str, Model],
    rng: np.random.Generator,
    spread: Callable[..., Iterable[Any]] = map,
) -> Mapping[str, Model]:
    """Candidates refitted once more, from starts all over the prior; none is worse than before.

    Parameters
    ----------
    model : without them
    candidates : as `refits` left them, by id
    rng : for the starts
    spread : map over the candidates, e.g. an executor's
    """
    count = len(candidates)
    found = spread(_refit_again, [model] * count, candidates.values(), rng.spawn(count))
    return dict(zip(candidates, found, strict=True))


def refit_like(candidate: Model, model: Model, other: Model, rng: np.random.Generator) -> Model:
    """A candidate refitted from the shape that its effect has on another record.

    Parameters
    ----------
    candidate, other : with the effect, as their last
    model : the candidate without it
    rng : for starts of the drive's parameters all over the prior, which may stand in for the effect
    """
    likelihood = candidate.likelihood
    scales = likelihood.reduced.course.scales
    theirs = other.likelihood.effect_set.at_scales(other.start.point[COUNT + 1 :], scales)
    shapes = [theirs[-len(likelihood.effects[-1].parameters(scales)) :]]
    if other.ids == candidate.ids:
        # The initial slip and what it has besides may have settled elsewhere as well.
        shapes.append(np.concatenate([other.start.point[COUNT : COUNT + 1], theirs]))
    found = [candidate]
    for simpler in _beside(model) if np.isfinite(theirs).all() else ():
        wider = replace(simpler.likelihood, effects=likelihood.effects)
        points = [
            np.concatenate([start.point[: wider.size - shape.size], shape])
            for start in simpler.starts[:2]
            for shape in shapes
        ]
        near = [start.point for start in descend_all(wider, points, 16)]
        starts = starting_points(wider, rng, starts=4, known=[points[0], *near])
        found += _settled(Model(wider, tuple(starts)), simpler)
    return max(found, key=lambda one: one.log_evidence)


def _refit(beside: Sequence[Model], effect: Effect) -> Model:
    """Beside white noise and beside the model's own, whichever says more for the effect."""
    found = []
    for simpler in beside:
        wider = replace(simpler.likelihood, effects=(*simpler.likelihood.effects, effect))
        starts = effect_starts(wider, simpler.starts)
        found += _settled(Model(wider, tuple(starts)), simpler)
    return max(found, key=lambda candidate: candidate.log_evidence)


def _refit_again(model: Model, candidate: Model, rng: np.random.Generator) -> Model:
    found = [candidate]
    white = _beside_white(candidate)
    starts = search_widely(white.likelihood, white.starts, rng)
    found += _settled(Model(white.likelihood, tuple(starts)), _beside_white(model))
    if candidate.likelihood.noise.whitening is not None:
        starts = search_widely(candidate.likelihood, candidate.starts, rng)
        found += _settled(Model(candidate.likelihood, tuple(starts)), model)
    return max(found, key=lambda one: one.log_evidence)


def _settled(candidate: Model, simpler: Model) -> list[Model]:
    """The candidate, and where it is worth it with its noise found anew, both within reach."""
    candidate = _within_reach(candidate, simpler)
    if candidate.log_evidence - simpler.log_evidence < _WORTH_SETTLING:
        return [candidate]
    again = settled(candidate.likelihood, candidate.starts)
    return [candidate, _within_reach(again, simpler)]


def _within_reach(candidate: Model, simpler: Model) -> Model:
    """The candidate's modes whose effects the record can carry; with none left, it is absent."""
    likelihood = candidate.likelihood
    inside = tuple(start for start in candidate.starts if within_reach(likelihood, start))
    if len(inside) == len(candidate.starts):
        return candidate
    if not inside:
        new = likelihood.effects[-1].parameters(likelihood.reduced.course.scales)
        own = [parameter.absent if parameter.amplitude else 0.0 for parameter in new]
        inside = (describe(likelihood, np.concatenate([simpler.start.point, own])),)
    return Model(likelihood, inside)


def _beside(model: Model) -> list[Model]:
    """The model beside white noise, and as it is where its noise is another."""
    white = _beside_white(model)
    return [white] if model.likelihood.noise.whitening is None else [white, model]


def _beside_white(model: Model) -> Model:
    likelihood = replace(model.likelihood, noise=model.likelihood.noise.as_white)
    starts = [describe(likelihood, start.point) for start in model.starts]
    return Model(likelihood, tuple(sorted(starts, key=lambda start: start.deviance)))


def without(model: Model, removed: str, rng: np.random.Generator) -> Model:
    """The model with one effect taken out, its modes and noise found anew."""
    likelihood = model.likelihood
    scales = likelihood.reduced.course.scales
    kept = [True] * (COUNT + 1)
    for effect in likelihood.effects:
        kept += [effect.id != removed] * len(effect.parameters(scales))
    fewer = tuple(effect for effect in likelihood.effects if effect.id != removed)
    white = replace(likelihood, effects=fewer, noise=likelihood.noise.as_white)
    known = [start.point[np.array(kept)] for start in model.starts[:2]]
    return settled(white, starting_points(white, rng, starts=2, known=known))
