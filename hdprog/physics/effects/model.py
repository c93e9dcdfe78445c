"""The drive model with effects: torque errors before it, side parameters in it, angles after it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.effects.base import Effect, EffectParameter, Values
from hdprog.physics.parameters import FloatArray, Parameters


@dataclass(frozen=True)
class EffectSet:
    """Effects in a fixed order, with the layout of their joint coordinates.

    Attributes
    ----------
    effects : the terms
    scales : of the record that their priors suit
    """

    effects: tuple[Effect, ...]
    scales: Scales

    def __add__(self, other: Effect) -> EffectSet:
        """With one effect more."""
        return EffectSet((*self.effects, other), self.scales)

    @cached_property
    def parameters(self) -> tuple[tuple[Effect, EffectParameter], ...]:
        """Every parameter with its effect, in the order of the coordinates."""
        return tuple(
            (effect, parameter)
            for effect in self.effects
            for parameter in effect.parameters(self.scales)
        )

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.parameters)

    def values(self, coordinates: FloatArray) -> dict[str, Values]:
        """Physical values by effect and name, (draws, 1) each, of coordinates (draws, size)."""
        values: dict[str, dict[str, FloatArray]] = {effect.id: {} for effect in self.effects}
        for index, (effect, parameter) in enumerate(self.parameters):
            values[effect.id][parameter.name] = parameter.value(coordinates[:, index, None])
        return dict(values)

    def angle(
        self,
        course: Course,
        parameters: Parameters,
        values: dict[str, Values],
        alpha: float,
        fraction: FloatArray,
    ) -> FloatArray:
        """Torsion angle of drive and effects, (draws, samples) in rad.

        Parameters
        ----------
        course : the record's coordinates
        parameters : of the drive model by name, (draws,) each
        values : of the effects, see `values`
        alpha : gear-tooth angle in rad
        fraction : (draws,) initial slip as a fraction of the way between the envelopes
        """
        path, negative = course.path, None
        for effect in self.effects:
            if effect.acts_on == "torque":
                error = effect.torque_error(course, values[effect.id])
                before = (course.path.torque - path.torque, course.path.reached - path.reached)
                path = course.corrected(before[0] + error[0], before[1] + error[1])
            elif effect.acts_on == "parameters":
                negative = effect.negative_side(parameters, values[effect.id])
        angle = torsion_angle(path, parameters, alpha, initial_fraction=fraction, negative=negative)
        added = [
            effect.evaluate(course, values[effect.id], angle)
            for effect in self.effects
            if effect.acts_on == "angle"
        ]
        return np.asarray(sum(added, start=angle))
