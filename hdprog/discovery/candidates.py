"""Which mechanism: candidates refitted fully on top of a model, several starts each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hdprog.discovery.model import Model, settled
from hdprog.inference.effect_starts import effect_starts
from hdprog.inference.likelihood import COUNT
from hdprog.inference.noise import NoiseModel
from hdprog.inference.starting_points import describe, starting_points
from hdprog.physics.effects.base import Effect

_WORTH_SETTLING = 1.0  # log evidence gained beside white noise; below it no other noise helps


def refits(
    model: Model,
    effects: Sequence[Effect],
    rng: np.random.Generator,
    *,
    thorough: bool,
    spread: Callable[..., Iterable[Any]] = map,
) -> Mapping[str, Model]:
    """The model with each effect added in turn, its noise found anew; by the effect's id.

    Parameters
    ----------
    model : to add to
    effects : candidates that the record can show
    rng : for starts all over the prior
    thorough : start from draws of the prior beside the best shapes of the grid
    spread : map over the candidates, e.g. an executor's
    """
    count = len(effects)
    jobs = ([model] * count, effects, rng.spawn(count), [thorough] * count)
    found = spread(_refit, *jobs)
    return {effect.id: refitted for effect, refitted in zip(effects, found, strict=True)}


def _refit(model: Model, effect: Effect, rng: np.random.Generator, thorough: bool) -> Model:
    """Beside white noise and beside the model's own, whichever says more for the effect."""
    beside = [_beside_white(model)]
    if model.likelihood.noise.whitening is not None:
        beside.append(model)
    found = []
    for simpler in beside:
        wider = replace(simpler.likelihood, effects=(*model.likelihood.effects, effect))
        starts = effect_starts(wider, simpler.starts, rng, thorough=thorough)
        refitted = Model(wider, tuple(starts))
        found.append(refitted)
        if refitted.log_evidence - simpler.log_evidence > _WORTH_SETTLING:
            found.append(settled(wider, starts))
    return max(found, key=lambda candidate: candidate.log_evidence)


def _beside_white(model: Model) -> Model:
    noise = NoiseModel.white(model.likelihood.noise.white_sd)
    likelihood = replace(model.likelihood, noise=noise)
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
    white = replace(likelihood, effects=fewer, noise=NoiseModel.white(likelihood.noise.white_sd))
    known = [start.point[np.array(kept)] for start in model.starts[:2]]
    return settled(white, starting_points(white, rng, starts=2, known=known))
