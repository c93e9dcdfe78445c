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
_SHARES = (-0.05, 1.05)  # all and nothing lie inside


class ThermalDrift(Effect):
    """(d + g·T/T_max)·ϑ: the zero drifts by d, the angle under load by g.

    ϑ is the warm-up curve (1 − exp(−t/τ))/(1 − exp(−D/τ)) of a first-order system over the duration
    D. Where a temperature was recorded and moves, ϑ is a mean of the two, with the weight p for the
    temperature, scaled to 0 … 1: its sensor need not be where the rig warms up.
    """

    id = "thermal_drift"
    words = "angle or stiffness changes slowly as the rig warms up"
    advice = "Let the rig and the drive warm up before the test, and record the temperature."

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """Zero drift d and g in rad, τ in parts of the record, p."""
        telling = scales.warming is not None and scales.warming > _TELLING
        return (
            signed_amplitude("drift", "of the angle's zero over the record", scales),
            either_sign(
                "softening", "rad", "of the angle at the largest torque", 0.006 * scales.angle
            ),
            EffectParameter(
                "time_constant",
                "of the record",
                "of the warm-up, of what does not follow a temperature",
                "log",
                0.5,
                0.8,
                grid=(-1.5, 0.0, 1.5),
            ),
            # Of every record, so that the tests of a drive have the same parameters.
            EffectParameter(
                "temperature_share",
                "-",
                "part that follows the temperature, where one was recorded; the rest follows time",
                "between",
                *_SHARES,
                grid=(-1.5, 1.5) if telling else (0.0,),
            ),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        warmth = warming(course, values["time_constant"], values.get("temperature_share", 1.0))
        return np.asarray((values["drift"] + values["softening"] * course.load) * warmth)


def warming(course: Course, constant: FloatArray, share: FloatArray | float = 1.0) -> FloatArray:
    """ϑ along the course, (draws, samples), where a share of it follows the temperature, if known.

    Parameters
    ----------
    course : the record's coordinates
    constant : (draws, 1) τ
    share : (draws, 1) p
    """
    by_time = np.asarray(np.expm1(-course.clock / constant) / np.expm1(-1 / constant))
    temperature, coldest, gained = course.temperature, course.scales.coldest, course.scales.warming
    if temperature is None or coldest is None or gained is None or gained <= _TELLING:
        return by_time
    # By the record's own scale, whichever of its readings or their averages are asked for.
    by_temperature = (temperature - coldest) / gained
    return np.asarray(by_time + share * (by_temperature - by_time))
