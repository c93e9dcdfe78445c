"""A model of torsion other than the drive model, as a competitor on the same record.

Every parameter has a coordinate with a standard Gaussian prior, as those of the effects have, so
that one sampler serves all models. Angle offset and noise scale belong to the likelihood.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import EffectParameter as ModelParameter
from hdprog.physics.effects.base import Values
from hdprog.physics.parameters import FloatArray

Column = Literal["time_s", "output_angle_rad"]

__all__ = ["Column", "ModelParameter", "OtherModel", "Setting", "Values", "values_of"]


@dataclass(frozen=True)
class Setting:
    """What a model's priors are centred on.

    Attributes
    ----------
    scales : of the record
    low, high : smallest and largest torque of the record in Nm
    catalogue_torques : T1 and T2 in Nm of the maker's piecewise-linear stiffness, or None
    """

    scales: Scales
    low: float
    high: float
    catalogue_torques: tuple[float, float] | None = None

    @staticmethod
    def of(course: Course, catalogue_torques: tuple[float, float] | None = None) -> Setting:
        """The setting of a record."""
        torque = course.path.torque
        return Setting(course.scales, float(torque.min()), float(torque.max()), catalogue_torques)

    @property
    def torque(self) -> float:
        """Largest size of torque in Nm."""
        return self.scales.torque

    @property
    def angle(self) -> float:
        """About the torsion angle at that torque in rad."""
        return 2 * self.scales.angle * self.torque / (self.high - self.low)

    @property
    def stiffness(self) -> float:
        """Secant stiffness of the record in Nm/rad."""
        return self.torque / self.angle

    @property
    def two_sided(self) -> bool:
        """Whether the record has a fair share of both signs of torque."""
        return min(self.high, -self.low) > 0.2 * self.torque


class OtherModel(ABC):
    """A model that predicts the torsion angle along a record.

    Attributes
    ----------
    id : name in files
    words : its name in plain words
    source : equation of the paper, and the original
    where : on which records it says something, in words
    needs : columns that a record must have for the model to be defined on it
    hysteresis : whether rising and falling torque have branches of their own
    odd : whether the angle under −T mirrors that under T
    nonnegative : whether it is linear in coordinates that must not be negative; see
        `hdprog.physics.other_models.nonnegative`
    """

    id: ClassVar[str]
    words: ClassVar[str]
    source: ClassVar[str]
    where: ClassVar[str]
    needs: ClassVar[tuple[Column, ...]] = ()
    hysteresis: ClassVar[bool] = True
    odd: ClassVar[bool] = True
    nonnegative: ClassVar[bool] = False

    @abstractmethod
    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """The model's parameters with weakly informative priors that suit a record."""

    @abstractmethod
    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """Torsion angle along a course.

        Parameters
        ----------
        course : the record's coordinates
        values : physical values by name, (draws, 1) each
        setting : of the record that the model is fitted to

        Returns
        -------
        (draws, samples) in rad, without the encoder's offset
        """

    def inside(self, values: Values, setting: Setting) -> NDArray[np.bool_]:
        """(draws,) whether values lie in the hard support; all do unless a model says more."""
        first = next(iter(values.values()))
        return np.ones(len(first), dtype=bool)

    def stiffness_curve(
        self, torque: FloatArray, values: Values, setting: Setting
    ) -> FloatArray | None:
        """Torsion angle without friction at torques (samples,), (draws, samples) in rad.

        None where the model has no such curve of its own: the middle of its loop stands for it.
        """
        return None

    def missing(self, course: Course) -> str | None:
        """Why the model cannot be defined on a record, as "needs time_s"; None where it can."""
        there = {"time_s": course.time, "output_angle_rad": course.output_angle}
        lacking = [name for name in self.needs if there[name] is None]
        return "needs " + " and ".join(lacking) if lacking else None


def values_of(parameters: Sequence[ModelParameter], coordinates: FloatArray) -> Values:
    """Physical values by name, (draws, 1) each, at coordinates (draws, parameters)."""
    found: Mapping[str, FloatArray] = {
        parameter.name: parameter.value(coordinates[:, index, None])
        for index, parameter in enumerate(parameters)
    }
    return found
