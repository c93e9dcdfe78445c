"""Friction that grows with the rate of loading."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import (
    Effect,
    EffectParameter,
    Values,
    angle_amplitude,
    initial_state,
)
from hdprog.physics.first_order import follow
from hdprog.physics.parameters import FloatArray


class ViscousFriction(Effect):
    """−(w/2)·v with τ dv/dt = sign(dT/dt)·|dT/dt / r_max|^p − v, r_max the record's `Scales.rate`.

    τ is the short memory with which the friction follows the rate. Linear for p = 1; grease thins
    with shear, so p may be less (Tuttle and Seering, IEEE Trans. Robot. Autom. 12 (1996) 368, find
    friction that grows less than linearly).
    """

    id = "viscous_friction"
    words = "the loop is wider the faster it is run"
    needs = frozenset({"time", "several loading rates"})
    advice = (
        "Compare tests only at one loading rate, and slow ramps down; a growing value points to "
        "stiff or cold grease."
    )
    lasting = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """W in rad, p, τ in s, initial state."""
        duration = scales.duration if scales.duration is not None else 1.0
        return (
            angle_amplitude("width", "width of the loop added at the largest rate", scales),
            EffectParameter(
                "exponent", "-", "power of the rate", "log", 0.8, 0.25, grid=(-1.0, 1.0)
            ),
            EffectParameter(
                "memory", "s", "time constant of the friction", "log", 0.003 * duration, 1.5
            ),
            initial_state("friction at the first sample, −1 to 1 of that at the largest rate"),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        assert course.rate is not None
        assert course.scales.rate is not None
        speed = np.maximum(np.abs(course.rate) / course.scales.rate, 1e-9)
        steady = np.exp(values["exponent"] * np.log(speed))  # a power, quicker
        steady *= course.path.direction
        shape = follow(course, steady, values["memory"], values["initial_state"])
        shape *= -0.5 * values["width"]
        return shape
