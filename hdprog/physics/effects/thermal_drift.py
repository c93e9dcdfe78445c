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
from hdprog.physics.warm_up import warm_up


class ThermalDrift(Effect):
    """(d + g·T/T_max)·ϑ: the zero drifts by d, the angle under load by g.

    ϑ is the warm-up curve (1 − exp(−t/τ))/(1 − exp(−D/τ)) of a first-order system over the duration
    D. Where a temperature was recorded and moves, q times what it does beside its own nearest such
    curve is added: q is 1 where the drift follows the temperature, and 0 where it does not, for its
    sensor need not be where the rig warms up. A share of the whole temperature would leave open
    how it divides between two curves that are as good as one.
    """

    id = "thermal_drift"
    words = "angle or stiffness changes slowly as the rig warms up"
    advice = "Let the rig and the drive warm up before the test, and record the temperature."

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """Zero drift d and g in rad, τ in parts of the record, q."""
        return (
            signed_amplitude("drift", "of the angle's zero over the record", scales),
            either_sign(
                "softening", "rad", "of the angle at the largest torque", 0.006 * scales.angle
            ),
            EffectParameter(
                "time_constant",
                "of the record",
                "of the warm-up",
                "log",
                0.5,
                0.8,
                grid=(-1.5, 0.0, 1.5),
            ),
            # Of every record, so that the tests of a drive have the same parameters.
            EffectParameter(
                "temperature_gain",
                "-",
                "by which the drift follows what a recorded temperature does beside a warm-up",
                "normal",
                0.5,
                0.5,
                grid=(0.0,) if scales.warm_up is None else (-1.0, 1.0),
                told=scales.warm_up is not None,
            ),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        warmth = warm_up(course.clock, values["time_constant"])
        if course.temperature_beside is not None:
            warmth += values["temperature_gain"] * course.temperature_beside
        return np.asarray((values["drift"] + values["softening"] * course.load) * warmth)
