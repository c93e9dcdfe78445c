"""Model angles about points, a step along each coordinate: what finite differences are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray

if TYPE_CHECKING:
    from hdprog.inference.likelihood import LoopLikelihood


def stepped_angles(
    likelihood: LoopLikelihood, points: FloatArray, steps: Sequence[float]
) -> FloatArray:
    """Angles at points (points, size), and at each step from them along one coordinate.

    Where effects add to the drive's angle whatever it is, neither is worked out again while the
    other's coordinates move.

    Returns
    -------
    (points, 1 + steps·size, blocks) in rad: the points themselves, then step by step
    """
    size = likelihood.size
    shifts = np.vstack([np.zeros(size), *(step * np.eye(size) for step in steps)])
    near = points[:, None, :] + shifts
    effects = likelihood.effect_set.effects if likelihood.held is None else ()
    if not effects or not all(one.acts_on == "angle" and not one.follows_angle for one in effects):
        return _angles(likelihood, near)
    moved = np.append(-1, np.tile(np.arange(size), len(steps)))
    first = size - likelihood.effect_set.size
    angles = np.empty((*near.shape[:2], likelihood.blocks))
    of_drive = np.flatnonzero(moved < first)
    drive = _angles(replace(likelihood, effects=()), near[:, of_drive, :first])
    angles[:] = drive[:, :1]
    angles[:, of_drive] = drive
    course, scales = likelihood.reduced.course, likelihood.effect_set.scales
    for effect in effects:
        one = EffectSet((effect,), scales)
        own = slice(first, first + one.size)
        rows = np.flatnonzero((moved == -1) | ((moved >= own.start) & (moved < own.stop)))
        values = one.values(near[:, rows, own].reshape(-1, one.size))
        added = effect.evaluate(course, values[effect.id], course.load[None])
        added = added.reshape(len(points), rows.size, -1)
        angles += added[:, :1]
        angles[:, rows[1:]] += added[:, 1:] - added[:, :1]
        first = own.stop
    return angles


def _angles(likelihood: LoopLikelihood, near: FloatArray) -> FloatArray:
    """(points, shifts, blocks) at (points, shifts, size)."""
    points, shifts, size = near.shape  # a model may have no coordinates at all
    found = likelihood.angle(near.reshape(points * shifts, size))
    return found.reshape(points, shifts, likelihood.blocks)
