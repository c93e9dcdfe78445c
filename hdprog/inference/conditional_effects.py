"""Effects drawn about their own best values at every draw of the drive's parameters.

One linear model about the mode is too coarse where the drive's parameters can stand in for an
effect: soft teeth for play, say. Best values then differ from draw to draw, so they are sought for
each (Gauss and Newton), and effects are drawn from the Gaussian that the angle's slope has there.
Importance weights against the exact density make up for the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.likelihood import LoopLikelihood
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray

_STEP = 1e-4  # of the finite differences, in effects' coordinates (of order 1 each)
_ITERATIONS = 3
_SHORTER = (1.0, 0.3, 0.09)  # shares of a step, until one leads down
# Bounded coordinates have longer tails than a Gaussian: some draws go farther.
_WIDE_SHARE, _WIDE = 0.2, 2.5
_TOGETHER = 128  # draws whose angles stay in the processor's cache


def draw_effects(
    exact: LoopLikelihood,
    points: FloatArray,
    offset: FloatArray,
    scale: FloatArray,
    begin: FloatArray,
    beside: FloatArray,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Points with effects, and how much more probable the exact density makes them.

    Parameters
    ----------
    exact : likelihood with the effects' coordinates in a point
    points, offset, scale : (draws, 9), (draws,) in rad, (draws,) of the noise; given
    begin : (draws, k) effects' coordinates at which the search begins
    beside : (k,) others, taken where they are better
    rng : source of randomness

    Returns
    -------
    (draws, 9 + k), and (draws,) log of likelihood and prior of the effects over the density that
    they were drawn from; −inf outside the support
    """
    complete, log_ratio = np.empty((len(points), exact.size)), np.empty(len(points))
    with np.errstate(over="ignore", invalid="ignore"):
        for start in range(0, len(points), _TOGETHER):
            part = slice(start, start + _TOGETHER)
            given = _Given.of(exact, points[part], offset[part], scale[part])
            best = _best(given, (begin[part], np.broadcast_to(beside, begin[part].shape)))
            effects, log_density = _drawn(given, best, rng)
            complete[part] = np.hstack([points[part], effects])
            log_ratio[part] = -given.at(effects).cost - log_density
    inside = np.isfinite(log_ratio) & exact.supported(complete)
    return complete, np.where(inside, log_ratio, -np.inf)


@dataclass(frozen=True)
class _At:
    """Effects' coordinates (draws, k), what they leave over the noise, and what that costs."""

    effects: FloatArray
    left: FloatArray
    cost: FloatArray

    def or_better(self, other: _At) -> _At:
        """Draw by draw whichever costs less."""
        better = other.cost < self.cost
        return replace(
            self,
            effects=np.where(better[:, None], other.effects, self.effects),
            left=np.where(better[:, None], other.left, self.left),
            cost=np.where(better, other.cost, self.cost),
        )


@dataclass(frozen=True)
class _Given:
    """What is given while the effects are sought.

    Attributes
    ----------
    bare : (draws, blocks) angle that effects are added to; None where one acts on what gives it
    """

    exact: LoopLikelihood
    points: FloatArray
    offset: FloatArray
    scale: FloatArray
    bare: FloatArray | None

    @staticmethod
    def of(
        exact: LoopLikelihood, points: FloatArray, offset: FloatArray, scale: FloatArray
    ) -> _Given:
        effects, bare = exact.effect_set, None
        if effects.angle_effects == effects.effects:
            bare = exact.angle_with(points, {}, EffectSet((), effects.scales))
        return _Given(exact, points, offset, scale, bare)

    def at(self, effects: FloatArray) -> _At:
        left = self.exact.whiten(self.exact.fitted - self._angle(effects) - self.offset[:, None])
        left = left / self.scale[:, None]
        cost = 0.5 * np.einsum("db,db->d", left, left) + 0.5 * np.sum(effects**2, axis=1)
        return _At(effects, left, np.where(np.isfinite(cost), cost, np.inf))

    def _angle(self, effects: FloatArray) -> FloatArray:
        exact, bare = self.exact, self.bare
        if bare is None:
            return exact.angle(np.hstack([self.points, effects]))
        values, course = exact.effect_set.values(effects), exact.reduced.course
        added = (one.evaluate(course, values[one.id], bare) for one in exact.effects)
        return np.asarray(sum(added, start=bare))

    def slopes(self, here: _At) -> FloatArray:
        """(draws, k, blocks) of what is left, by the effects' coordinates."""
        moved = (self.at(here.effects + step) for step in _STEP * np.eye(here.effects.shape[1]))
        return np.stack([(each.left - here.left) / _STEP for each in moved], axis=1)


def _best(given: _Given, begin: tuple[FloatArray, ...]) -> _At:
    here, *others = (given.at(effects) for effects in begin)
    for other in others:
        here = here.or_better(other)
    for _ in range(_ITERATIONS):
        slopes = given.slopes(here)
        downhill = -np.einsum("dkb,db->dk", slopes, here.left) - here.effects
        step = np.linalg.solve(_precision(slopes), downhill[..., None])[..., 0]
        before = here
        for share in _SHORTER:
            here = here.or_better(given.at(before.effects + share * step))
            if np.all(here.cost < before.cost):
                break
    return here


def _precision(slopes: FloatArray) -> FloatArray:
    """(draws, k, k) of the effects' coordinates, their prior included."""
    usable = np.where(np.isfinite(slopes), slopes, 0.0)
    return np.asarray(np.einsum("dkb,dlb->dkl", usable, usable) + np.eye(slopes.shape[1]))


def _drawn(given: _Given, best: _At, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Coordinates (draws, k) about the best ones, some from wider Gaussians, and log density."""
    root = np.linalg.cholesky(_precision(given.slopes(best)))
    draws, size = best.effects.shape
    spread = np.where(rng.random(draws) < _WIDE_SHARE, _WIDE, 1.0)
    normal = spread[:, None] * rng.standard_normal((draws, size))
    away = np.linalg.solve(root.swapaxes(1, 2), normal[..., None])[..., 0]
    squares = np.sum(normal**2, axis=1)
    narrow = np.log1p(-_WIDE_SHARE) - 0.5 * squares
    wide = np.log(_WIDE_SHARE) - size * np.log(_WIDE) - 0.5 * squares / _WIDE**2
    density = np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1)
    return best.effects + away, density + np.logaddexp(narrow, wide)
