"""Compliance that falls or rises with load: an odd power of torque."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, either_sign
from hdprog.physics.parameters import FloatArray


class CupHardening(Effect):
    """κ·sign(T)·|T/T_max|^p, T_max the record's largest torque.

    For p = 3 the odd term behind the linear one, as in the cubic stiffness of Tuttle (eq. 9), as
    compliance; κ < 0 is hardening. How sharply a contact closes under load depends on its shape, so
    p is free about it: a wrong power bends the drive's own stiffness.
    """

    id = "cup_hardening"
    words = "stiffness that changes with load up to the highest torques"
    advice = (
        "Repeat the test to a lower torque: if the curve bends only near the top, look for a part "
        "that touches or lifts off under load. Stiffness is told without this bend; near the top "
        "the loop's own slope is the one that the joint has."
    )
    lasting = True
    static = True
    at_torque = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """κ in rad, p."""
        meaning = "angle added at the largest torque, above zero where the drive softens"
        return (
            either_sign("hardening", "rad", meaning, 0.01 * scales.angle),
            EffectParameter("exponent", "-", "power of the torque", "log", 3.0, 0.25),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        power = np.abs(course.load) ** values["exponent"]
        return np.asarray(values["hardening"] * np.sign(course.load) * power)
