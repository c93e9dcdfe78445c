"""Stiffness as a cubic (eq. 9)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.course import Course
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.other_models.odd_spring import OddSpring, spring_parameters
from hdprog.physics.parameters import FloatArray

_NAMES = ("a1", "a3")


class Cubic(OtherModel):
    """T = a1·Δθ + a3·Δθ³ (9), solved for the angle; a3 of either sign. No friction."""

    id = "cubic"
    words = "cubic stiffness"
    source = "eq. 9"
    where = "any record"
    hysteresis = False

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """a1 in Nm/rad, a3 in Nm/rad³."""
        return spring_parameters(_NAMES, setting)

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.angle`."""
        return self.stiffness_curve(course.path.torque, values, setting)

    def inside(self, values: Values, setting: Setting) -> NDArray[np.bool_]:
        """Torque grows with angle."""
        return OddSpring.of(values, _NAMES, setting).rises()

    def stiffness_curve(self, torque: FloatArray, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.stiffness_curve`."""
        return OddSpring.of(values, _NAMES, setting).angle(torque)
