"""Compliance that falls or rises with load: a cubic in torque."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, either_sign
from hdprog.physics.parameters import FloatArray


class CupHardening(Effect):
    """κ·(T/T_max)³, T_max the record's largest torque.

    The odd term behind the linear one, as in the cubic stiffness of Tuttle (eq. 9), as compliance;
    κ < 0 is hardening.
    """

    id = "cup_hardening"
    words = "stiffness that changes with load up to the highest torques"
    advice = (
        "Repeat the test to a lower torque: if the curve bends only near the top, look for a part "
        "that touches or lifts off under load."
    )
    lasting = True
    static = True
    at_torque = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """κ in rad."""
        meaning = "angle added at the largest torque"
        return (either_sign("cubic", "rad", meaning, 0.01 * scales.angle),)

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        return np.asarray(values["cubic"] * course.load**3)
