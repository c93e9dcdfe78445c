"""A fitted loop as the trend takes it: its likelihood, relinearised wherever asked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtri

from hdprog.inference.information import Linearised, information_form
from hdprog.inference.likelihood import COUNT, LoopLikelihood, sigmoid
from hdprog.inference.posterior import Posterior
from hdprog.physics.effects.base import Effect, Values
from hdprog.physics.parameters import FloatArray
from hdprog.trend.centred_loop import CentredLoop
from hdprog.trend.exact_likelihood import ExactLikelihood, Nuisances
from hdprog.trend.followed_effects import FollowedEffects, Located

_NEWTON_STEPS = 4
_LARGEST_STEP = 1.0  # prior spreads of a nuisance
_FARTHEST_SCORE = 6.0  # of the initial slip's fraction


@dataclass(frozen=True)
class FittedLoop:
    """One test of a drive; see `evidence.LoopEvidence`.

    Attributes
    ----------
    service_hours, event, load_hours, temperature_C : of the test
    posterior : (draws, n) coordinates, then amplitudes of the effects that are followed
    likelihood : with the loop's own effects and all that are followed
    point : (size,) where its nuisances are held for linearisations
    variance : s², the noise scale squared
    followed : effects whose amplitudes are part of the state
    """

    service_hours: float
    event: str | None
    load_hours: float | None
    temperature_C: float | None
    posterior: FloatArray
    likelihood: LoopLikelihood
    point: FloatArray
    variance: float
    followed: FollowedEffects | None

    @staticmethod
    def of(
        fitted: Posterior,
        service_hours: float,
        event: str | None = None,
        temperature_C: float | None = None,
        load_hours: float | None = None,
        followed: FollowedEffects | None = None,
    ) -> FittedLoop:
        """From a test's posterior, whose prior is left out."""
        likelihood, point = fitted.likelihood, fitted.points.mean(axis=0)
        coordinates = fitted.coordinates
        if followed is not None:
            likelihood, point = _with_all(likelihood, point, followed)
            found = followed.amplitudes(fitted.effect_values, len(coordinates))
            coordinates = np.concatenate([coordinates, found], axis=1)
        variance = float(np.mean(fitted.noise_scale**2)) * likelihood.widening**2
        return FittedLoop(
            service_hours,
            event,
            load_hours,
            temperature_C,
            coordinates,
            likelihood,
            point,
            variance,
            followed,
        )

    @property
    def exact(self) -> FittedLoop:
        """Itself: a loop's likelihood is not Gaussian."""
        return self

    def linearise(self, coordinates: FloatArray) -> Linearised:
        """Information form of the likelihood at coordinates and amplitudes (n,)."""
        point = self.point.copy()
        residual, derivative, columns = self._derivative(coordinates, point)
        return information_form(residual, derivative, coordinates, point, columns, self.variance)

    def about(self, coordinates: FloatArray) -> tuple[ExactLikelihood, Nuisances]:
        """See `exact_likelihood.ExactEvidence`; effects that are not followed are centred."""
        own, derivative = self._settled(coordinates)
        centred = np.flatnonzero(np.isin(self.own_columns, self._free))
        if not centred.size:
            return self, own
        return CentredLoop.of(self, centred, own, derivative[:, centred])

    def own_at(self, coordinates: FloatArray) -> FloatArray:
        """See `exact_likelihood.ExactLikelihood`."""
        return self.nuisances(coordinates).mean

    def nuisances(self, coordinates: FloatArray) -> Nuisances:
        """Normal score of the initial slip's fraction, and what effects have beside amplitudes."""
        return self._settled(coordinates)[0]

    def _settled(self, coordinates: FloatArray) -> tuple[Nuisances, FloatArray]:
        """The same, and the derivative (blocks, k) of the whitened angle by them."""
        point, own = self.point.copy(), self.own_columns
        scores = point[own]
        scores[0] = np.clip(ndtri(sigmoid(scores[:1]))[0], -_FARTHEST_SCORE, _FARTHEST_SCORE)
        for number in range(_NEWTON_STEPS + 1):
            point[own] = scores
            point[COUNT] = _logit(scores[:1])[0]
            residual, derivative, columns = self._derivative(coordinates, point)
            derivative[:, COUNT] *= _logit_slope(float(scores[0]))
            beside = derivative[:, own]
            precision = beside.T @ beside / self.variance + np.eye(own.size)
            if number < _NEWTON_STEPS:
                pull = -beside.T @ residual / self.variance - scores
                step = np.linalg.solve(precision, pull)
                scores = scores + np.clip(step, -_LARGEST_STEP, _LARGEST_STEP)
        cross = beside.T @ derivative[:, columns] / self.variance
        return Nuisances(scores, np.asarray(-np.linalg.solve(precision, cross)), precision), -beside

    def log_likelihood(self, coordinates: FloatArray, nuisances: FloatArray) -> FloatArray:
        """(draws,) log L at coordinates and amplitudes (draws, n) and nuisances (draws, k)."""
        with np.errstate(all="ignore"):
            points = self.points(coordinates, nuisances)
            angle = self.likelihood.angle_with(points, self.effect_values(points, coordinates))
            density = self.likelihood.log_likelihood_of(angle)
            inside = np.isfinite(density) & self.likelihood.supported(points)
        return np.where(inside, density, -np.inf)

    def points(self, coordinates: FloatArray, nuisances: FloatArray) -> FloatArray:
        """Points (draws, size) of the likelihood at a state's numbers and a test's own."""
        points = np.empty((len(coordinates), self.likelihood.size))
        points[:, :COUNT] = coordinates[:, :COUNT]
        points[:, self.own_columns] = nuisances
        points[:, COUNT] = _logit(nuisances[:, 0])
        for column, place in self._located(coordinates[:, COUNT:]):
            points[:, column] = place.coordinate
        return points

    def effect_values(self, points: FloatArray, coordinates: FloatArray) -> dict[str, Values]:
        """Values of the effects by id and name, (draws, 1) each.

        An amplitude that its own coordinate cannot reach counts all the same: the angle is
        proportional to those.
        """
        values = self.likelihood.effect_values(points)
        if self.followed is not None:
            found = self.followed.amplitude_values(coordinates[:, COUNT:])
            for (effect, name), amplitude in found.items():
                values[effect] = {**values[effect], name: amplitude}
        return values

    @cached_property
    def free_effects(self) -> tuple[Effect, ...]:
        """Effects that are not followed: all their numbers are the test's own."""
        followed = () if self.followed is None else self.followed.ids
        return tuple(one for one in self.likelihood.effects if one.id not in followed)

    @cached_property
    def _free(self) -> list[int]:
        """Columns of a point that hold the numbers of those."""
        free = {effect.id for effect in self.free_effects}
        each = enumerate(self.likelihood.effect_set.parameters)
        return [COUNT + 1 + index for index, (effect, _) in each if effect.id in free]

    @cached_property
    def own_columns(self) -> NDArray[np.intp]:
        """Columns of a point that are no part of the state."""
        return np.setdiff1d(np.arange(COUNT, self.point.size), self._columns)

    @cached_property
    def _columns(self) -> list[int]:
        """Columns of a point that hold the followed amplitudes."""
        return [column for column, _ in self._located(np.zeros((1, self._amplitudes)))]

    @property
    def _amplitudes(self) -> int:
        return 0 if self.followed is None else self.followed.size

    def _derivative(
        self, coordinates: FloatArray, point: FloatArray
    ) -> tuple[FloatArray, FloatArray, NDArray[np.intp]]:
        """Whitened residual and its derivative, and the columns that are the state's numbers.

        The state's numbers in the point are set to coordinates and amplitudes (n,).
        """
        point[:COUNT] = coordinates[:COUNT]
        located = self._located(coordinates[None, COUNT:])
        columns = np.concatenate([np.arange(COUNT), self._columns])
        for column, place in located:
            point[column] = place.coordinate[0]
        residual, derivative = self.likelihood.jacobian(point)
        derivative = derivative.copy()
        for column, place in located:
            derivative[:, column] *= place.slope[0]
            residual = residual + derivative[:, column] * place.beyond[0]
        return residual, derivative, columns.astype(np.intp)

    def _located(self, amplitudes: FloatArray) -> list[tuple[int, Located]]:
        """Of each amplitude in (draws, followed), its column in a point and where it lies there."""
        if self.followed is None:
            return []
        places = {
            (effect.id, parameter.name): (COUNT + 1 + index, parameter)
            for index, (effect, parameter) in enumerate(self.likelihood.effect_set.parameters)
        }
        return [
            (places[name][0], self.followed.located(name, places[name][1], column))
            for name, column in zip(self.followed.units, amplitudes.T, strict=True)
        ]


def _logit(score: FloatArray) -> FloatArray:
    """Logit (...) of the fraction whose normal score (...) is given."""
    return np.asarray(log_ndtr(score) - log_ndtr(-score))


def _logit_slope(score: float) -> float:
    step = 1e-4
    ends = _logit(np.array([score - step, score + step]))
    return float(ends[1] - ends[0]) / (2 * step)


def _with_all(
    likelihood: LoopLikelihood, point: FloatArray, followed: FollowedEffects
) -> tuple[LoopLikelihood, FloatArray]:
    """A likelihood with the followed effects that it lacks, shaped as other tests have them."""
    lacking = tuple(one for one in followed.effects if one not in likelihood.effects)
    wider = replace(likelihood, effects=(*likelihood.effects, *lacking))
    scales = likelihood.reduced.course.scales
    shapes = [
        parameter.coordinate(followed.values[effect.id, parameter.name])
        for effect in lacking
        for parameter in effect.parameters(scales)
    ]
    return wider, np.concatenate([point, shapes])
