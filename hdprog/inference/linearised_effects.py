"""Effects integrated out while the drive model is sampled, then drawn.

Near their best values ẑ the angle is linear in the effects' coordinates,
f(x, z) ≈ f(x, ẑ) + E (z − ẑ). With their standard Gaussian prior, z is integrated out exactly: −E ẑ
joins the model and E Eᵀ the noise. The sampler then sees nine dimensions whatever effects there
are. Afterwards z is drawn about its own best values at each draw (see `conditional_effects`), and
the draws are taken again by importance weights against the exact density, whose Pareto k says
whether that holds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.conditional_effects import Linear, draw_effects
from hdprog.inference.likelihood import COUNT, HeldEffects, LoopLikelihood
from hdprog.inference.pareto_weights import pareto_weights, worth
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.parameters import FloatArray

PARETO_K_LIMIT = 0.7
_WORST_PARETO_K = 1.0  # beyond, the weights have no mean: the draws stand for nothing
_TOGETHER = 128
_FARTHEST = 6.0  # prior standard deviations at which a search begins
_FEWEST_EFFECTIVE = 100.0  # weighted draws that may stand for a posterior
_TRIES = (6, 24)  # of an effect's values a draw; more where these leave weights of no use


@dataclass(frozen=True)
class EffectDraws:
    """Draws with the effects' coordinates in them.

    Attributes
    ----------
    points : (draws, size)
    offset, scale : (draws,) of the angle in rad, of the noise
    pareto_k : of the weights of the exact density over that which they were drawn from
    effective : draws that the weighted ones are worth
    weighted : whether the draws were taken again by the weights: not where few would be left
    """

    points: FloatArray
    offset: FloatArray
    scale: FloatArray
    pareto_k: float
    effective: float
    weighted: bool

    @property
    def exact(self) -> bool:
        """Whether they follow the exact density, which they do roughly where Pareto k is high."""
        return self.weighted and self.pareto_k <= PARETO_K_LIMIT

    @property
    def usable(self) -> bool:
        """Whether they stand for the posterior at all."""
        return self.weighted and self.pareto_k <= _WORST_PARETO_K


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
        temperature: float = 1.0,
    ) -> EffectDraws:
        """Draws of the exact density, given draws of the linearised one without the effects.

        Parameters
        ----------
        points, offset, scale : (draws, 9), (draws,) in rad, (draws,)
        groups : of draws that follow each other and share nothing; they stay apart
        rng : source of randomness
        temperature : of the linearised likelihood, of which the points are draws
        """
        for tries in _TRIES:
            found = self._drawn(points, offset, scale, groups, tries, rng, temperature)
            if found.usable:
                break
        return found

    def _drawn(
        self,
        points: FloatArray,
        offset: FloatArray,
        scale: FloatArray,
        groups: int,
        tries: int,
        rng: np.random.Generator,
        temperature: float,
    ) -> EffectDraws:
        complete, log_ratio = np.empty((len(points), self.exact.size)), np.empty(len(points))
        # Few points at a time: their angles stay in the processor's cache.
        for start in range(0, len(points), _TOGETHER):
            part = slice(start, start + _TOGETHER)
            complete[part], log_ratio[part] = self._complete(
                points[part], offset[part], scale[part], tries, rng
            )
        if temperature != 1.0:
            log_ratio += (1.0 - 1.0 / temperature) * self.sampled.log_likelihood(points)
        weight, pareto_k = pareto_weights(log_ratio)
        effective = worth(weight)
        weighted = effective >= _FEWEST_EFFECTIVE
        if weighted:
            parts = np.split(weight, groups)
            chosen = np.concatenate(
                [at * len(part) + _systematic(part, rng) for at, part in enumerate(parts)]
            )
            complete, offset, scale = complete[chosen], offset[chosen], scale[chosen]
        return EffectDraws(complete, offset, scale, pareto_k, effective, weighted)

    def _complete(
        self,
        points: FloatArray,
        offset: FloatArray,
        scale: FloatArray,
        tries: int,
        rng: np.random.Generator,
    ) -> tuple[FloatArray, FloatArray]:
        """Points with effects (draws, size), and log of the exact density over the drawn one."""
        assert self.sampled.held is not None
        left = self.sampled.fitted - self.sampled.angle(points) - offset[:, None]
        white = self.sampled.whiten(left)
        effects = np.clip(white @ self._pulled / self.scale, -_FARTHEST, _FARTHEST)
        slopes = self._slopes
        linear = Linear(effects, self.exact.whiten(left) + effects @ slopes, slopes)
        best = self.sampled.held.coordinates
        given = (points, offset, scale, linear, best, tries)
        complete, log_ratio = draw_effects(self.exact, *given, rng)
        return complete, log_ratio + 0.5 * np.sum(white**2, axis=1) / scale**2

    @cached_property
    def _pulled(self) -> FloatArray:
        """(blocks, k) what pulls the mean of the effects, given a point."""
        return self.sampled.whiten(self.features.T).T

    @cached_property
    def _slopes(self) -> FloatArray:
        """(k, blocks) of what the exact model leaves, whitened, by the effects' coordinates."""
        return -self.scale * self.exact.whiten(self.features.T)


def _systematic(weight: FloatArray, rng: np.random.Generator) -> NDArray[np.intp]:
    """As many indices as weights (n,), in order, each as often as its weight asks, up to one."""
    passed = np.cumsum(weight)
    places = (np.arange(len(weight)) + rng.random()) * passed[-1] / len(weight)
    return np.asarray(np.minimum(np.searchsorted(passed, places), len(weight) - 1), np.intp)
