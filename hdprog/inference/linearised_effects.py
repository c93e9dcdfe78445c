"""Effects integrated out while the drive model is sampled, then drawn.

Near their best values ẑ the angle is linear in the effects' coordinates,
f(x, z) ≈ f(x, ẑ) + E (z − ẑ). With their standard Gaussian prior, z is integrated out exactly: −E ẑ
joins the model and E Eᵀ the noise. The sampler then sees nine dimensions whatever effects there
are. Afterwards z is drawn from its exact conditional distribution, and the draws are taken again by
importance weights against the exact density, whose Pareto k says whether that holds. Where it does
not, z is drawn about its own best values at each draw (see `conditional_effects`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.conditional_effects import draw_effects
from hdprog.inference.likelihood import COUNT, HeldEffects, LoopLikelihood
from hdprog.inference.pareto_weights import pareto_weights, worth
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.parameters import FloatArray

PARETO_K_LIMIT = 0.7
_TOGETHER = 256
_FARTHEST = 6.0  # prior standard deviations at which a search begins
_FEWEST_EFFECTIVE = 100.0  # weighted draws that may stand for a posterior


@dataclass(frozen=True)
class EffectDraws:
    """Draws with the effects' coordinates in them.

    Attributes
    ----------
    points : (draws, size)
    offset, scale : (draws,) of the angle in rad, of the noise
    pareto_k : of the weights of the exact density over that which they were drawn from
    effective : draws that the weighted ones are worth
    exact : whether they follow the exact density; what they were drawn from if the weights do not
        hold
    """

    points: FloatArray
    offset: FloatArray
    scale: FloatArray
    pareto_k: float
    effective: float
    exact: bool


@dataclass(frozen=True)
class LinearisedEffects:
    """The likelihood with its effects linearised about a mode.

    Attributes
    ----------
    exact : with the effects' coordinates in a point
    sampled : without them, nine coordinates
    scale : that noise scale
    """

    exact: LoopLikelihood
    sampled: LoopLikelihood
    scale: float

    @property
    def features(self) -> FloatArray:
        """(blocks, k) E over the noise scale at the mode."""
        assert self.sampled.held is not None
        return self.sampled.held.features

    @staticmethod
    def about(exact: LoopLikelihood, start: StartingPoint) -> LinearisedEffects:
        """Linearise about a mode of the exact likelihood."""
        best = start.point[COUNT + 1 :]
        points = np.tile(start.point, (2 * best.size, 1))
        step = 1e-4 * np.eye(best.size)
        points[: best.size, COUNT + 1 :] += step
        points[best.size :, COUNT + 1 :] -= step
        angles = exact.angle(points)
        derivative = (angles[: best.size] - angles[best.size :]).T / 2e-4
        scale = float(np.sqrt(start.variance))
        held = HeldEffects(best, -derivative @ best, derivative / scale)
        return LinearisedEffects(exact, replace(exact, held=held), scale)

    def draws(
        self,
        points: FloatArray,
        offset: FloatArray,
        scale: FloatArray,
        groups: int,
        rng: np.random.Generator,
    ) -> EffectDraws:
        """Draws of the exact density, given draws of the linearised one without the effects.

        Parameters
        ----------
        points, offset, scale : (draws, 9), (draws,) in rad, (draws,)
        groups : of draws that follow each other and share nothing; they stay apart
        rng : source of randomness
        """
        given = (points, offset, scale)
        found = _weighted(given, *self._about_the_mode(*given, rng), groups, rng)
        if not found.exact:
            found = _weighted(given, *self._about_their_own(*given, rng), groups, rng)
        return found

    @cached_property
    def _conditional(self) -> tuple[FloatArray, FloatArray]:
        """Of the effects given a point: what pulls their mean, (blocks, k), and their scatter."""
        pulled = self.sampled.whiten(self.features.T).T
        spread = np.eye(self.features.shape[1]) - pulled.T @ pulled
        values, vectors = np.linalg.eigh(0.5 * (spread + spread.T))
        return pulled, vectors * np.sqrt(np.maximum(values, 0.0))

    def _about_the_mode(
        self, points: FloatArray, offset: FloatArray, scale: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        complete, log_ratio = np.empty((len(points), self.exact.size)), np.empty(len(points))
        # Few points at a time: their angles stay in the processor's cache.
        for start in range(0, len(points), _TOGETHER):
            part = slice(start, start + _TOGETHER)
            complete[part], log_ratio[part] = self._complete(
                points[part], offset[part], scale[part], rng
            )
        return complete, log_ratio

    def _complete(
        self, points: FloatArray, offset: FloatArray, scale: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Points with effects (draws, size), and log of the exact density over the linearised."""
        own = self.exact
        _, factor = self._conditional
        left, mean = self._left(points, offset)
        drawn = rng.standard_normal(mean.shape) @ factor.T
        effects = (mean + scale[:, None] * drawn) / self.scale
        complete = np.hstack([points, effects])
        linear = left - effects @ (self.features.T * self.scale)
        exact = own.fitted - own.angle(complete) - offset[:, None]
        squares = [np.sum(own.whiten(each) ** 2, axis=1) for each in (exact, linear)]
        log_ratio = 0.5 * (squares[1] - squares[0]) / scale**2
        # Integrated out, the effects' prior is as wide as the noise scale over the mode's.
        wider = scale / self.scale
        log_ratio += 0.5 * np.sum(effects**2, axis=1) * (wider**-2 - 1.0)
        log_ratio += effects.shape[1] * np.log(wider)
        return complete, log_ratio

    def _left(self, points: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What is left to the effects, (draws, blocks), and their mean by it over the scale."""
        left = self.sampled.fitted - self.sampled.angle(points) - offset[:, None]
        return left, self.sampled.whiten(left) @ self._conditional[0]

    def _about_their_own(
        self, points: FloatArray, offset: FloatArray, scale: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """As `_about_the_mode`, with the effects linearised about what suits each draw best."""
        assert self.sampled.held is not None
        begin, log_density = [], []
        for start in range(0, len(points), _TOGETHER):
            part = slice(start, start + _TOGETHER)
            left, mean = self._left(points[part], offset[part])
            begin.append(np.clip(mean / self.scale, -_FARTHEST, _FARTHEST))
            squares = np.sum(self.sampled.whiten(left) ** 2, axis=1)
            log_density.append(-0.5 * squares / scale[part] ** 2)
        complete, log_ratio = draw_effects(
            self.exact,
            points,
            offset,
            scale,
            np.concatenate(begin),
            self.sampled.held.coordinates,
            rng,
        )
        return complete, log_ratio - np.concatenate(log_density)


def _weighted(
    given: tuple[FloatArray, FloatArray, FloatArray],
    complete: FloatArray,
    log_ratio: FloatArray,
    groups: int,
    rng: np.random.Generator,
) -> EffectDraws:
    """Draws taken again by their weights, group by group, if these hold."""
    _, offset, scale = given
    weight, pareto_k = pareto_weights(log_ratio)
    effective = worth(weight)
    exact = pareto_k <= PARETO_K_LIMIT and effective >= _FEWEST_EFFECTIVE
    if exact:
        parts = np.split(weight, groups)
        chosen = np.concatenate(
            [at * len(part) + _systematic(part, rng) for at, part in enumerate(parts)]
        )
        complete, offset, scale = complete[chosen], offset[chosen], scale[chosen]
    return EffectDraws(complete, offset, scale, pareto_k, effective, exact)


def _systematic(weight: FloatArray, rng: np.random.Generator) -> NDArray[np.intp]:
    """As many indices as weights (n,), in order, each as often as its weight asks, up to one."""
    passed = np.cumsum(weight)
    places = (np.arange(len(weight)) + rng.random()) * passed[-1] / len(weight)
    return np.asarray(np.minimum(np.searchsorted(passed, places), len(weight) - 1), np.intp)
