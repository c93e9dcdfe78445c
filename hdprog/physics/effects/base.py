"""An effect beside the drive model: an immutable term with priors and one evaluation.

Every parameter has a coordinate with a standard Gaussian prior, so that terms compose without
further bookkeeping and an effect of plausible size is of order one in each coordinate.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
from scipy.special import ndtr, ndtri

from hdprog.physics.course import Course, Scales
from hdprog.physics.parameters import FloatArray, Parameters

Need = Literal["both signs of torque", "time", "several loading rates", "output angle", "reversal"]
Values = Mapping[str, FloatArray]
"""Physical values of an effect's parameters by name, (draws, 1) each."""

_FARTHEST = 6.0
_ABSENT = -30.0


@dataclass(frozen=True)
class EffectParameter:
    """One parameter of an effect and its prior.

    Attributes
    ----------
    name, unit, meaning : in the field's words
    transform : "normal" value = first + second·z; "log" value = first·exp(second·z); "signed"
        value = first·sinh(second·z), of either sign over several decades; "between" uniform from
        first to second, value = first + (second − first)·Φ(z)
    first, second : numbers of the transform, in the parameter's unit where they have one
    amplitude : whether the effect is proportional to it (or nearly)
    grid : coordinates at which a search for the effect begins
    told : whether the record can tell it at all; nothing is shown of one that has but its prior
    """

    name: str
    unit: str
    meaning: str
    transform: Literal["normal", "log", "signed", "between"]
    first: float
    second: float
    amplitude: bool = False
    grid: tuple[float, ...] = (0.0,)
    told: bool = True

    def value(self, coordinate: FloatArray) -> FloatArray:
        """Physical value (...) of a coordinate (...)."""
        if self.transform == "normal":
            return np.asarray(self.first + self.second * coordinate)
        if self.transform == "log":
            return np.asarray(self.first * np.exp(self.second * coordinate))
        if self.transform == "signed":
            return np.asarray(self.first * np.sinh(self.second * coordinate))
        return np.asarray(self.first + (self.second - self.first) * ndtr(coordinate))

    def coordinate(self, value: float) -> float:
        """Coordinate of a physical value, held to what the prior can have drawn."""
        return float(self.coordinates(np.asarray(value)))

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Coordinates (...) of physical values (...), held to what the prior can have drawn."""
        if self.transform == "normal":
            return np.asarray((values - self.first) / self.second)
        if self.transform == "signed":
            return np.asarray(np.arcsinh(values / self.first) / self.second)
        if self.transform == "log":
            deviates = np.log(np.maximum(values, 1e-300) / self.first) / self.second
        else:
            deviates = ndtri((values - self.first) / (self.second - self.first))
        return np.asarray(np.clip(deviates, -_FARTHEST, _FARTHEST))

    @property
    def absent(self) -> float:
        """Coordinate at which an amplitude is as good as zero."""
        return _ABSENT if self.transform == "log" else 0.0

    def gridded(self, values: FloatArray) -> EffectParameter:
        """The same parameter with a search that begins at these physical values (points,)."""
        return replace(self, grid=tuple(self.coordinates(values).tolist()))


class Effect(ABC):
    """A term beside the drive model.

    Attributes
    ----------
    id : name in files and on the command line
    words : what it is, in a few plain words
    acts_on : "torque" (an error of its sensor), "parameters" (of the negative side) or "angle"
    needs : what a record must have for the effect to be told at all
    advice : what to do about it
    rivals : ids of effects of a like trace; where a record cannot rule them out, or cannot show
        them, what is said to do about it is `unsure_advice`
    unsure_advice : see `rivals`
    lasting : whether wear can bring it, so that it is followed over service time
    static : whether it follows from the torque's path alone, so that it is part of the steady
        cycle of the figures of merit
    at_torque : whether what it adds to the angle sits at a torque of the drive, not at one of the
        sensor's: errors of the reading are taken out of the course that it is given
    follows_angle : whether what it adds to the angle hangs on the drive model's, not on the course
        alone
    divides_width : whether the loop's width divides between it and the drive's own friction by the
        shape that it is given here, of which intervals know only what is near it
    """

    id: ClassVar[str]
    words: ClassVar[str]
    acts_on: ClassVar[Literal["torque", "parameters", "angle"]] = "angle"
    needs: ClassVar[frozenset[Need]] = frozenset()
    advice: ClassVar[str]
    rivals: ClassVar[frozenset[str]] = frozenset()
    unsure_advice: ClassVar[str] = ""
    lasting: ClassVar[bool] = False
    static: ClassVar[bool] = False
    at_torque: ClassVar[bool] = False
    follows_angle: ClassVar[bool] = False
    divides_width: ClassVar[bool] = False

    def __eq__(self, other: object) -> bool:
        """Whether it is the same effect: one that comes from another process is another object."""
        return type(self) is type(other)

    def __hash__(self) -> int:
        return hash(type(self))

    @abstractmethod
    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """The effect's parameters with priors that suit a record of these scales."""

    def told_parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """Those of them that a record of these scales can tell."""
        return tuple(one for one in self.parameters(scales) if one.told)

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """What the effect adds to the torsion angle.

        Parameters
        ----------
        course : the record's coordinates; its torque may be (draws, samples) if `at_torque`
        values : physical values by name, (draws, 1) each
        angle : (draws, samples) angle of the drive model in rad; of effects that do not follow it,
            any array of so many samples

        Returns
        -------
        (draws, samples) in rad
        """
        raise NotImplementedError(f"{self.id} acts on {self.acts_on}")

    def torque_error(self, course: Course, values: Values) -> tuple[FloatArray, FloatArray]:
        """What the torque reading is too high by, along the course and at the stretches' ends.

        Returns
        -------
        (draws, samples) and (draws, stretches) in Nm
        """
        raise NotImplementedError(f"{self.id} acts on {self.acts_on}")

    def negative_side(self, parameters: Parameters, values: Values) -> Parameters:
        """Parameters of the drive model for negative torque, by name, (draws,) each."""
        raise NotImplementedError(f"{self.id} acts on {self.acts_on}")


def angle_amplitude(name: str, meaning: str, scales: Scales) -> EffectParameter:
    """A positive amplitude in rad: around a percent of half the angle's range, within a decade."""
    return EffectParameter(name, "rad", meaning, "log", 0.01 * scales.angle, 1.5, amplitude=True)


def either_sign(name: str, unit: str, meaning: str, typical: float) -> EffectParameter:
    """An amplitude of either sign: as soon a few times `typical` as a few ten times."""
    return EffectParameter(name, unit, meaning, "signed", typical, 2.0, amplitude=True)


def signed_amplitude(name: str, meaning: str, scales: Scales) -> EffectParameter:
    """An amplitude of either sign in rad, from a thousandth of the angle's range to a tenth."""
    return either_sign(name, "rad", meaning, 0.003 * scales.angle)


def initial_state(meaning: str) -> EffectParameter:
    """State at the first sample of an element whose history is not known."""
    return EffectParameter("initial_state", "-", meaning, "between", -1.0, 1.0)
