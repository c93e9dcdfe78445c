"""Where to begin the fit of an effect: the best of a grid of its shapes, by a score test.

The part of a shape that the fitted sensitivities cannot imitate is compared with the residual:
for amplitudes A with projected signatures S and residual r the deviance falls by bᵀ(SᵀS + 1)⁻¹b,
b = Sᵀr (Rao's score test with the parameters' priors). The search tells where to start only; what
counts is the full refit that follows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from hdprog.errors import BadInputError
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.starting_points import (
    StartingPoint,
    descend,
    descend_all,
    describe,
    starting_points,
)
from hdprog.physics.course import Course
from hdprog.physics.effects.base import Effect, EffectParameter, Need
from hdprog.physics.parameters import FloatArray

_SMALL = 0.2  # of an amplitude's typical size
_SMALLEST_COORDINATE = -3.0
_STRAINED = 2.5  # prior standard deviations
_BEST = 3  # shapes of the grid that a mode starts with
_ALIKE = 0.9  # correlation above which two shapes make one start
_POLISH = 60  # iterations: a start from far away may need many
_SEVERAL_RATES = 1.6
_BOTH_SIGNS = 0.1


def unmet(effect: Effect, course: Course) -> tuple[Need, ...]:
    """What an effect needs and a record lacks; empty where it can be told."""
    torque, largest = course.path.torque, course.scales.torque
    met: dict[Need, bool] = {
        "both signs of torque": bool(
            torque.min() < -_BOTH_SIGNS * largest and torque.max() > _BOTH_SIGNS * largest
        ),
        "time": course.time is not None,
        "several loading rates": _several_rates(course),
        "output angle": bool(course.scales.sweep),
        "reversal": course.path.starts.size > 1,
    }
    return tuple(need for need in sorted(effect.needs) if not met[need])


def _several_rates(course: Course) -> bool:
    if course.rate is None:
        return False
    rates = np.sort(np.abs(course.rate))
    moving = rates[rates > 0.02 * rates[-1]]
    low, high = np.quantile(moving, (0.1, 0.9))
    return bool(high > _SEVERAL_RATES * low)


def require(effect: Effect, course: Course, source: str) -> None:
    """Refuse an effect that a record cannot show.

    Raises
    ------
    BadInputError
        naming what the record lacks
    """
    lacking = unmet(effect, course)
    if lacking:
        raise BadInputError(
            found="a record without " + " and ".join(lacking),
            where=source,
            expected=f"{' and '.join(sorted(effect.needs))}, which {effect.id} needs",
            advice=f"Leave {effect.id} out, or repeat the test so that the record has it.",
        )


@dataclass(frozen=True)
class _Shapes:
    """Grid of an effect's shapes: coordinates (points, size), amplitudes still absent."""

    coordinates: FloatArray
    parameters: tuple[EffectParameter, ...]

    @staticmethod
    def of(parameters: tuple[EffectParameter, ...]) -> _Shapes:
        axes = [
            (parameter.absent,) if parameter.amplitude else parameter.grid
            for parameter in parameters
        ]
        return _Shapes(np.array(list(product(*axes))), parameters)

    @property
    def amplitudes(self) -> list[int]:
        return [index for index, parameter in enumerate(self.parameters) if parameter.amplitude]


def effect_starts(
    likelihood: LoopLikelihood, without: Sequence[StartingPoint]
) -> list[StartingPoint]:
    """Modes of a likelihood whose last effect is new, found from the best shapes of its grid.

    For each of two modes, and for the best one with what stands in for the effect taken back.

    Parameters
    ----------
    likelihood : with the new effect last
    without : modes of the same without it, best first

    Returns
    -------
    at least one StartingPoint, best first
    """
    simpler = replace(likelihood, effects=likelihood.effects[:-1])
    points = [point for start in without[:2] for point in _best_shapes(likelihood, start)]
    modes = descend_all(likelihood, points, 16)
    # By themselves: they begin far behind the others, where starts are given up.
    for start in _relaxed(simpler, without[0]):
        modes += descend_all(likelihood, _best_shapes(likelihood, start))
    if not modes:
        modes = [describe(likelihood, points[0])]
    return sorted(modes, key=lambda start: start.deviance)


def strained(likelihood: LoopLikelihood, start: StartingPoint) -> FloatArray:
    """Prior standard deviations (8,) by which parameters that only fit far out are; else 0."""
    away = (start.point - likelihood.prior_mean)[:COUNT] / likelihood.prior_sd[:COUNT]
    return np.where(np.abs(away) > _STRAINED, away, 0.0)


def _relaxed(likelihood: LoopLikelihood, start: StartingPoint) -> list[StartingPoint]:
    """The mode with its strained parameters where their prior has them; none where none is.

    Beside a mode that has bent itself to an effect, as teeth far too soft do to play, the residual
    has nothing of it left.
    """
    far = strained(likelihood, start) != 0.0
    if not far.any():
        return []
    point = start.point.copy()
    point[:COUNT] = np.where(far, likelihood.prior_mean[:COUNT], point[:COUNT])
    return [describe(likelihood, point)] if likelihood.supported(point[None]).all() else []


def search_widely(
    likelihood: LoopLikelihood, modes: Sequence[StartingPoint], rng: np.random.Generator
) -> list[StartingPoint]:
    """The same with starts from draws of the prior as well, and the best mode polished."""
    found = starting_points(likelihood, rng, starts=4, known=[start.point for start in modes[:2]])
    polished = descend(likelihood, found[0].point, _POLISH)
    if polished is not None and polished.deviance < found[0].deviance:
        found[0] = polished
    return found


def _best_shapes(likelihood: LoopLikelihood, start: StartingPoint) -> list[FloatArray]:
    """Points (size,) with the shapes that the residual of a simpler mode asks for most."""
    *before, effect = likelihood.effects
    simpler = replace(likelihood, effects=tuple(before))
    parameters = effect.parameters(likelihood.reduced.course.scales)
    shapes = _Shapes.of(parameters)
    signatures, steps = _signatures(likelihood, start, shapes)
    scale = np.sqrt(start.variance)
    residual, derivative = simpler.jacobian(start.point)
    # What the parameters can imitate, as far as their priors let them.
    imitated = np.vstack([derivative / scale, np.diag(1 / likelihood.prior_sd[: simpler.size])])
    basis = np.linalg.qr(imitated)[0]
    blocks = likelihood.blocks
    left = np.zeros(imitated.shape[0])
    left[:blocks] = residual / scale
    left -= basis @ (basis.T @ left)
    padded = np.zeros((*signatures.shape[:2], imitated.shape[0]))
    padded[:, :, :blocks] = signatures / scale
    padded -= (padded @ basis) @ basis.T
    gram = np.einsum("gin,gjn->gij", padded, padded) + np.eye(steps.size) * 1e-2
    pull = padded @ left
    amplitude = np.linalg.solve(gram, pull[..., None])[..., 0]
    positive = np.array([parameters[index].transform == "log" for index in shapes.amplitudes])
    gain = np.einsum("gi,gi->g", pull, amplitude)
    wrong = (amplitude < 0)[:, positive].any(axis=1)
    gain = np.where(wrong, 1e-3 * gain, gain)
    chosen: list[int] = []
    explained = np.einsum("gi,gin->gn", amplitude, padded)
    explained /= np.linalg.norm(explained, axis=1, keepdims=True) + 1e-300
    for index in np.argsort(-gain):
        if all(abs(explained[index] @ explained[other]) < _ALIKE for other in chosen):
            chosen.append(int(index))
        if len(chosen) == _BEST:
            break
    points = []
    for index in chosen:
        coordinates = shapes.coordinates[index].copy()
        for column, which in enumerate(shapes.amplitudes):
            value = amplitude[index, column] * steps[column]
            lowest = _SMALLEST_COORDINATE if positive[column] else -np.inf
            coordinates[which] = max(parameters[which].coordinate(value), lowest)
        points.append(np.concatenate([start.point, coordinates]))
    return points


def _signatures(
    likelihood: LoopLikelihood, start: StartingPoint, shapes: _Shapes
) -> tuple[FloatArray, FloatArray]:
    """Whitened change of the angle by a small amplitude, (points, amplitudes, blocks), and sizes.

    Sizes (amplitudes,) are those small amplitudes in their units.
    """
    effect = likelihood.effects[-1]
    grid, which = shapes.coordinates, shapes.amplitudes
    course, number = likelihood.reduced.course, len(shapes.coordinates)
    steps = np.array([_SMALL * shapes.parameters[index].first for index in which])
    points = np.repeat(grid[:, None, :], len(which), axis=1)
    for column, index in enumerate(which):
        points[:, column, index] = shapes.parameters[index].coordinate(float(steps[column]))
    flat = points.reshape(-1, grid.shape[1])
    if effect.acts_on == "angle":
        simpler = replace(likelihood, effects=likelihood.effects[:-1])
        angle = simpler.angle(start.point[None, :])
        values = {
            parameter.name: parameter.value(flat[:, index, None])
            for index, parameter in enumerate(shapes.parameters)
        }
        others = simpler.effect_values(start.point[None, :])
        seen = simpler.effect_set.course_of(effect, course, others)
        change = effect.evaluate(seen, values, angle)
        change = np.broadcast_to(change, (flat.shape[0], likelihood.blocks))
    else:
        both = np.vstack([flat, grid])
        full = np.hstack([np.tile(start.point, (both.shape[0], 1)), both])
        angles = likelihood.angle(full)
        change = angles[: flat.shape[0]] - np.repeat(angles[flat.shape[0] :], len(which), axis=0)
    projected = likelihood.project(np.array(change))
    return projected.reshape(number, len(which), -1), steps
