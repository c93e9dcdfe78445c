"""Effects drawn about their own best values at every draw of the drive's parameters.

One linear model about the mode is too coarse where the drive's parameters can stand in for an
effect: soft teeth for play, say. Best values then differ from draw to draw, so they are sought for
each (Gauss and Newton), and effects are drawn from the Gaussian that the angle's slope has there.
Importance weights against the exact density make up for the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from hdprog.inference.likelihood import LoopLikelihood
from hdprog.physics.effects.base import Effect
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray

_STEP = 1e-4  # of the finite differences, in effects' coordinates (of order 1 each)
_ITERATIONS = 3
_STRAIGHT = 0.05  # squared, in noise: what the linear model may be off by where it is kept to
_SETTLED = 0.05  # log density that a step promises: less is not worth it
_SHORTER = (1.0, 0.3, 0.09)  # shares of a step, until one leads down
# Bounded coordinates have longer tails than a Gaussian, seldom several at once: many draws go
# farther along one axis of its precision. Along all of them hardly any would come near the best.
_FAR_SHARE, _FAR = 0.5, 2.5


@dataclass(frozen=True)
class Linear:
    """What one linear model of the effects says at draws of the drive's parameters.

    Attributes
    ----------
    effects : (draws, k) coordinates that it finds best
    left : (draws, blocks) whitened, what they leave by it
    slopes : (k, blocks) of what is left, whitened, by the coordinates
    """

    effects: FloatArray
    left: FloatArray
    slopes: FloatArray


def draw_effects(
    exact: LoopLikelihood,
    points: FloatArray,
    offset: FloatArray,
    scale: FloatArray,
    linear: Linear,
    beside: FloatArray,
    number: int,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Points with effects, and how much more probable the exact density makes them.

    Parameters
    ----------
    exact : likelihood with the effects' coordinates in a point
    points, offset, scale : (draws, 9), (draws,) in rad, (draws,) of the noise; given
    linear : where the search begins; draws that it holds for need no other slopes
    beside : (k,) others to begin at, taken where they are better
    number : of tries about each best value: each costs one angle, no slopes
    rng : source of randomness

    Of each draw's tries one is taken by their weights, and their mean is its own weight: right on
    average for the density with the effects integrated out (importance sampling squared; Tran,
    Scharth, Pitt & Kohn, arXiv:1309.3339, 2013).

    Returns
    -------
    (draws, 9 + k), and (draws,) log of likelihood and prior of the effects over the density that
    they were drawn from; −inf outside the support
    """
    with np.errstate(over="ignore", invalid="ignore"):
        given = _Given.of(exact, points, offset, scale)
        best, slopes = _best(given, linear, beside)
        tries = [_tried(given, *_drawn(best, slopes, rng)) for _ in range(number)]
    effects, log_ratio = (np.stack(each) for each in zip(*tries, strict=True))
    chosen = np.argmax(log_ratio + rng.gumbel(size=log_ratio.shape), axis=0)
    complete = np.hstack([points, effects[chosen, np.arange(len(points))]])
    with np.errstate(invalid="ignore"):
        together = logsumexp(log_ratio, axis=0) - np.log(number)
    return complete, together


def _tried(
    given: _Given, effects: FloatArray, log_density: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Effects (draws, k), and log (draws,) of their density over that which they are from."""
    log_ratio = -given.at(effects).cost - log_density
    inside = given.exact.supported(np.hstack([given.points, effects]))
    return effects, np.where(inside & np.isfinite(log_ratio), log_ratio, -np.inf)


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

    def rows(self, chosen: NDArray[np.intp]) -> _At:
        """Some of the draws."""
        return _At(self.effects[chosen], self.left[chosen], self.cost[chosen])

    def with_rows(self, chosen: NDArray[np.intp], other: _At) -> _At:
        """Some of the draws replaced."""
        found = _At(self.effects.copy(), self.left.copy(), self.cost.copy())
        found.effects[chosen], found.left[chosen] = other.effects, other.left
        found.cost[chosen] = other.cost
        return found


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

    def rows(self, chosen: NDArray[np.intp]) -> _Given:
        """Some of the draws."""
        bare = None if self.bare is None else self.bare[chosen]
        each = (self.points[chosen], self.offset[chosen], self.scale[chosen])
        return _Given(self.exact, *each, bare)

    def at(self, effects: FloatArray) -> _At:
        left = self.exact.whiten(self.exact.fitted - self._angle(effects) - self.offset[:, None])
        left = left / self.scale[:, None]
        cost = 0.5 * np.einsum("db,db->d", left, left) + 0.5 * np.sum(effects**2, axis=1)
        return _At(effects, left, np.where(np.isfinite(cost), cost, np.inf))

    def _angle(self, effects: FloatArray) -> FloatArray:
        if self.bare is None:
            return self.exact.angle(np.hstack([self.points, effects]))
        added = (self._added(one, effects) for one in self.exact.effects)
        return np.asarray(sum(added, start=self.bare))

    def _added(self, effect: Effect, effects: FloatArray) -> FloatArray:
        """What an effect adds to the bare angle."""
        assert self.bare is not None
        values = self.exact.effect_set.values(effects)[effect.id]
        found = effect.evaluate(self.exact.reduced.course, values, self.bare)
        return np.broadcast_to(found, self.bare.shape)

    def slopes(self, here: _At) -> FloatArray:
        """(draws, k, blocks) of what is left, by the effects' coordinates."""
        each = enumerate(_STEP * np.eye(here.effects.shape[1]))
        if self.bare is None:
            left = [self.at(here.effects + step).left - here.left for _, step in each]
            return np.stack(left, axis=1) / _STEP
        owners = [effect for effect, _ in self.exact.effect_set.parameters]
        still = {one.id: self._added(one, here.effects) for one in self.exact.effects}
        changes = [
            self.exact.whiten(still[owners[at].id] - self._added(owners[at], here.effects + step))
            for at, step in each
        ]
        return np.stack(changes, axis=1) / (_STEP * self.scale[:, None, None])


def _best(given: _Given, linear: Linear, beside: FloatArray) -> tuple[_At, FloatArray]:
    """Best values draw by draw, near enough to draw about, and the slopes there."""
    here = given.at(linear.effects)
    scale = given.scale[:, None]
    slopes = linear.slopes / scale[:, None]
    bent = np.sum((here.left - linear.left / scale) ** 2, axis=1)
    going = np.flatnonzero(~(bent < _STRAIGHT))
    if going.size:
        part, before = given.rows(going), here.rows(going)
        start = before.or_better(part.at(np.broadcast_to(beside, before.effects.shape)))
        here, slopes[going] = here.with_rows(going, start), part.slopes(start)
    for _ in range(_ITERATIONS if going.size else 0):
        near = slopes[going]
        downhill = -np.einsum("dkb,db->dk", near, here.left[going]) - here.effects[going]
        step = np.linalg.solve(_precision(near), downhill[..., None])[..., 0]
        far = 0.5 * np.sum(downhill * step, axis=1) > _SETTLED
        going, step = going[far], step[far]
        if not going.size:
            break
        part, before = given.rows(going), here.rows(going)
        moved = before
        for share in _SHORTER:
            moved = moved.or_better(part.at(before.effects + share * step))
            if np.all(moved.cost < before.cost):
                break
        here = here.with_rows(going, moved)
        slopes[going] = part.slopes(moved)
    return here, slopes


def _precision(slopes: FloatArray) -> FloatArray:
    """(draws, k, k) of the effects' coordinates, their prior included."""
    usable = np.where(np.isfinite(slopes), slopes, 0.0)
    return np.asarray(np.einsum("dkb,dlb->dkl", usable, usable) + np.eye(slopes.shape[1]))


def _drawn(
    best: _At, slopes: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Coordinates (draws, k) about the best ones, some farther on one axis, and log density."""
    precision, axes = np.linalg.eigh(_precision(slopes))
    draws, size = best.effects.shape
    normal = rng.standard_normal((draws, size))
    far = np.flatnonzero(rng.random(draws) < _FAR_SHARE)
    normal[far, rng.integers(0, size, far.size)] *= _FAR
    away = np.einsum("dij,dj->di", axes, normal / np.sqrt(precision))
    near = np.log1p(-_FAR_SHARE) - 0.5 * np.sum(normal**2, axis=1)
    on_axis = logsumexp(0.5 * normal**2 * (1.0 - _FAR**-2), axis=1) - np.log(size * _FAR)
    farther = np.log(_FAR_SHARE) - 0.5 * np.sum(normal**2, axis=1) + on_axis
    density = 0.5 * np.log(precision).sum(axis=1) + np.logaddexp(near, farther)
    return best.effects + away, density
