"""A loop's own numbers, counted from where the loop puts them for the state that it is given.

Effects that are no part of the state have numbers z of their own in every test. Near their mode ẑ
the angle is linear in them, so that the state's numbers x leave them close to a Gaussian with the
precision P = GᵀG/s² + I and the mean

    m(x) = ẑ + P⁻¹(Gᵀ r(x)/s² − ẑ),

r being what the drive with ẑ leaves of the record, whitened, and G the derivative of the whitened
angle by z. In w = z − m(x) the density hardly hangs on x: chains move along x as if the effects
were integrated out, and it is the loop's own likelihood all the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray
from hdprog.trend.exact_likelihood import Nuisances

if TYPE_CHECKING:
    from hdprog.trend.loop_evidence import FittedLoop


@dataclass(frozen=True)
class CentredLoop:
    """The exact likelihood in a loop's centred numbers; see `exact_likelihood.ExactLikelihood`.

    Attributes
    ----------
    loop : the test
    centred : (k,) which of its own numbers are counted from m(x)
    best : (k,) ẑ
    start : (k,) m where `bare` is zero
    gain : (blocks, k) what an angle in rad takes from m
    bare : the model without the free effects; None where these are no sum beside it
    """

    loop: FittedLoop
    centred: NDArray[np.intp]
    best: FloatArray
    start: FloatArray
    gain: FloatArray
    bare: EffectSet | None

    @staticmethod
    def of(
        loop: FittedLoop,
        centred: NDArray[np.intp],
        own: Nuisances,
        derivative: FloatArray,
    ) -> tuple[CentredLoop, Nuisances]:
        """Count some of a loop's own numbers from m(x), and their Gaussian in these.

        Parameters
        ----------
        loop : the test
        centred : (k,) which of the own numbers
        own : Gaussian of all own numbers at their mode
        derivative : (blocks, k) G
        """
        likelihood, best = loop.likelihood, own.mean[centred]
        precision = own.precision[np.ix_(centred, centred)]
        pulled = np.linalg.solve(precision, derivative.T / loop.variance)
        gain = likelihood.project(np.eye(likelihood.blocks)) @ pulled.T
        start = best - np.linalg.solve(precision, best) + likelihood.fitted @ gain
        bare = None
        if (added := _added(loop, own.mean)) is not None:
            effects = likelihood.effect_set
            kept = tuple(one for one in effects.effects if one not in loop.free_effects)
            start, bare = start - added @ gain, EffectSet(kept, effects.scales)
        # The other numbers keep their marginal Gaussian; those that are centred know of nothing.
        others = np.setdiff1d(np.arange(own.mean.size), centred)
        cross = own.precision[np.ix_(others, centred)]
        marginal = np.zeros_like(own.precision)
        marginal[np.ix_(centred, centred)] = precision
        marginal[np.ix_(others, others)] = own.precision[np.ix_(others, others)] - (
            cross @ np.linalg.solve(precision, cross.T)
        )
        mean, slope = own.mean.copy(), own.slope.copy()
        mean[centred], slope[centred] = 0.0, 0.0
        counted = CentredLoop(loop, centred, best, start, gain, bare)
        return counted, Nuisances(mean, slope, marginal)

    def log_likelihood(self, coordinates: FloatArray, nuisances: FloatArray) -> FloatArray:
        """(draws,) log L φ(z)/φ(w) at coordinates (draws, n) and numbers (draws, k) with w."""
        loop, likelihood = self.loop, self.loop.likelihood
        own, beyond = nuisances.copy(), nuisances[:, self.centred]
        own[:, self.centred] = self.best
        with np.errstate(all="ignore"):
            points = loop.points(coordinates, own)
            angle = self._angle(points, coordinates)
            numbers = self.start - angle @ self.gain + beyond
            points[:, loop.own_columns[self.centred]] = numbers
            values = loop.effect_values(points, coordinates)
            if self.bare is None:
                angle = likelihood.angle_with(points, values)
            else:
                for effect in loop.free_effects:
                    angle += effect.evaluate(likelihood.reduced.course, values[effect.id], angle)
            density = likelihood.log_likelihood_of(angle)
            density += 0.5 * np.sum(beyond**2 - numbers**2, axis=1)
            inside = np.isfinite(density) & likelihood.supported(points)
        return np.where(inside, density, -np.inf)

    def own_at(self, coordinates: FloatArray) -> FloatArray:
        """Mode (k,) at coordinates (n,); of those that are counted from it, none."""
        own = self.loop.own_at(coordinates)
        own[self.centred] = 0.0
        return own

    def _angle(self, points: FloatArray, coordinates: FloatArray) -> FloatArray:
        """What m hangs on: angle (draws, blocks) without the free effects, or with these at ẑ."""
        known = self.bare is not None and not self.bare.effects
        values = {} if known else self.loop.effect_values(points, coordinates)
        return self.loop.likelihood.angle_with(points, values, self.bare)


def _added(loop: FittedLoop, own: FloatArray) -> FloatArray | None:
    """(blocks,) what free effects add at own numbers (k,); None where it hangs on the state."""
    free = EffectSet(loop.free_effects, loop.likelihood.effect_set.scales)
    # Errors of the torque's reading, which move other effects along the record, are never followed.
    if free.angle_effects != free.effects:
        return None
    state = np.zeros((1, loop.posterior.shape[1]))
    values = loop.effect_values(loop.points(state, own[None]), state)
    known = free.held(loop.likelihood.reduced.course, values).known
    added = [one for one in known if one is not None]
    return np.asarray(np.sum(added, axis=0)[0]) if len(added) == len(known) else None
