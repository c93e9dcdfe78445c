"""A fitted loop as the trend takes it: its likelihood, relinearised wherever asked."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.information import Linearised, information_form
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.posterior import Posterior
from hdprog.physics.parameters import FloatArray
from hdprog.trend.followed_effects import FollowedEffects, Located


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

    def linearise(self, coordinates: FloatArray) -> Linearised:
        """Information form of the likelihood at coordinates and amplitudes (n,)."""
        point = self.point.copy()
        point[:COUNT] = coordinates[:COUNT]
        located = self._located(coordinates[COUNT:])
        columns = np.concatenate([np.arange(COUNT), [column for column, _ in located]])
        for column, place in located:
            point[column] = place.coordinate
        residual, derivative = self.likelihood.jacobian(point)
        derivative = derivative.copy()
        for column, place in located:
            derivative[:, column] *= place.slope
            residual = residual + derivative[:, column] * place.beyond
        return information_form(
            residual, derivative, coordinates, point, columns.astype(np.intp), self.variance
        )

    def _located(self, amplitudes: FloatArray) -> list[tuple[int, Located]]:
        """Of each amplitude, its column in a point and where it lies there."""
        if self.followed is None:
            return []
        places = {
            (effect.id, parameter.name): (COUNT + 1 + index, parameter)
            for index, (effect, parameter) in enumerate(self.likelihood.effect_set.parameters)
        }
        return [
            (places[name][0], self.followed.coordinate(name, places[name][1], float(amplitude)))
            for name, amplitude in zip(self.followed.units, amplitudes, strict=True)
        ]


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
