"""The drive model with effects: torque errors before it, side parameters in it, angles after it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.effects.base import Effect, EffectParameter, Values
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.torque_path import TorquePath


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

    def at_scales(self, coordinates: FloatArray, scales: Scales) -> FloatArray:
        """Coordinates (size,) that stand for the same values where the priors suit other scales.

        Not finite where those priors cannot have drawn them.
        """
        others = EffectSet(self.effects, scales).parameters
        both = zip(self.parameters, others, coordinates, strict=True)
        return np.array(
            [float(there.coordinates(here.value(x))) for (_, here), (_, there), x in both]
        )

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
        path = self.corrected_path(course, values)
        found = self.drive_angle(path, parameters, values, alpha, fraction)
        seen = _seen_from(course, path)
        added = [one.evaluate(seen(one), values[one.id], found) for one in self.angle_effects]
        return np.asarray(sum(added, start=found))

    def held(self, course: Course, values: dict[str, Values]) -> EffectsHeld:
        """The effects at one set of values along one course, worked out as far as it goes."""
        path = self.corrected_path(course, values)
        seen = _seen_from(course, path)
        known = tuple(
            None if one.follows_angle else one.evaluate(seen(one), values[one.id], course.load)
            for one in self.angle_effects
        )
        return EffectsHeld(self, course, values, path, known)

    def corrected_path(self, course: Course, values: dict[str, Values]) -> TorquePath:
        """The torque path with the errors of the torque's reading taken out."""
        path = course.path
        for effect in self.effects:
            if effect.acts_on == "torque":
                error = effect.torque_error(course, values[effect.id])
                before = (course.path.torque - path.torque, course.path.reached - path.reached)
                path = course.corrected(before[0] + error[0], before[1] + error[1])
        return path

    def course_of(self, effect: Effect, course: Course, values: dict[str, Values]) -> Course:
        """The course as an effect on the angle is given it, beside these effects."""
        return _seen_from(course, self.corrected_path(course, values))(effect)

    @cached_property
    def angle_effects(self) -> tuple[Effect, ...]:
        """The effects that act on the angle, in order."""
        return tuple(effect for effect in self.effects if effect.acts_on == "angle")

    def drive_angle(
        self,
        path: TorquePath,
        parameters: Parameters,
        values: dict[str, Values],
        alpha: float,
        fraction: FloatArray,
    ) -> FloatArray:
        """Angle of the drive along a corrected path, effects on its parameters included."""
        negative = None
        for effect in self.effects:
            if effect.acts_on == "parameters":
                negative = effect.negative_side(parameters, values[effect.id])
        return torsion_angle(path, parameters, alpha, initial_fraction=fraction, negative=negative)


@dataclass(frozen=True)
class EffectsHeld:
    """Effects whose values stay as they are while the drive's parameters change.

    Attributes
    ----------
    effects, course, values : as in `EffectSet.angle`, one draw of values
    path : of torque, errors of its reading taken out
    known : what each effect on the angle adds, (1, samples) in rad; None where it hangs on the
        angle itself
    """

    effects: EffectSet
    course: Course
    values: dict[str, Values]
    path: TorquePath
    known: tuple[FloatArray | None, ...]

    def angle(self, parameters: Parameters, alpha: float, fraction: FloatArray) -> FloatArray:
        """See `EffectSet.angle`."""
        found = self.effects.drive_angle(self.path, parameters, self.values, alpha, fraction)
        each = zip(self.effects.angle_effects, self.known, strict=True)
        added = [
            effect.evaluate(self.course, self.values[effect.id], found) if one is None else one
            for effect, one in each
        ]
        return np.asarray(sum(added, start=found))


def _seen_from(course: Course, path: TorquePath) -> Callable[[Effect], Course]:
    """The course that each effect is given where a torque path has been corrected.

    What sits at a torque of the drive, as play at none, sits there whatever the sensor reads.
    """
    corrected = course if path is course.path else replace(course, path=path)
    return lambda effect: corrected if effect.at_torque else course
