"""Angle and stiffness that follow the temperature, or a slow drift in time."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import (
    Effect,
    EffectParameter,
    Values,
    either_sign,
    signed_amplitude,
)
from hdprog.physics.parameters import FloatArray

_TELLING = 0.5  # °C: a recorded temperature that moves less says nothing about a drift


class ThermalDrift(Effect):
    """(d + g·T/T_max)·ϑ: the zero drifts by d, the angle under load by g.

    ϑ is the temperature over the record, scaled to 0 … 1, where it was recorded and moves; else the
    warm-up curve (1 − exp(−t/τ))/(1 − exp(−D/τ)) of a first-order system over the duration D.
    """

    id = "thermal_drift"
    words = "angle or stiffness changes slowly as the rig warms up"
    advice = "Let the rig and the drive warm up before the test, and record the temperature."

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """d and g in rad, τ in parts of the record."""
        return (
            signed_amplitude("drift", "of the angle's zero over the record", scales),
            either_sign(
                "softening", "rad", "of the angle at the largest torque", 0.006 * scales.angle
            ),
            EffectParameter(
                "time_constant",
                "of the record",
                "of the warm-up, where no temperature tells it",
                "log",
                0.5,
                0.8,
                grid=(-1.5, 0.0, 1.5),
            ),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        warmth = warming(course, values["time_constant"])
        return np.asarray((values["drift"] + values["softening"] * course.load) * warmth)


def warming(course: Course, constant: FloatArray) -> FloatArray:
    """ϑ along the course, (draws, samples) or (1, samples)."""
    temperature, coldest, gained = course.temperature, course.scales.coldest, course.scales.warming
    if temperature is None or coldest is None or gained is None or gained <= _TELLING:
        return np.asarray(np.expm1(-course.clock / constant) / np.expm1(-1 / constant))
    # By the record's own scale, whichever of its readings or their averages are asked for.
    return np.asarray((temperature - coldest) / gained)[None, :]
