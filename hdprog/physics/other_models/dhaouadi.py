"""Dhaouadi's hereditary model: odd quintic stiffness and an exponential memory (A1-A3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.course import Course
from hdprog.physics.effects.base import initial_state
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.other_models.odd_spring import OddSpring, spring_parameters
from hdprog.physics.other_models.spring_with_lag import angle_with_lag
from hdprog.physics.parameters import FloatArray

_NAMES = ("b1", "b2", "b3")


class Dhaouadi(OtherModel):
    """T = b1·Δθ + b2·Δθ³ + b3·Δθ⁵ + z with dz = A·dΔθ − β·z·|dΔθ| (A1-A3).

    On a cycle to ± Q the memory z is that of (A1) and (A2) with exp(−2βQ) in their denominators;
    the paper prints exp(−2Q) there, which solves the equation for β = 1 only. From any other
    history z follows its differential equation, so that one-sided and minor loops are defined.
    """

    id = "dhaouadi"
    words = "Dhaouadi (hereditary)"
    source = "A1-A3; Dhaouadi, Ghorbel & Gandhi, IEEE Trans. Industrial Electronics 50 (2003)"
    where = "any record with a reversal"

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """b1, b2, b3, A in Nm/rad, β in 1/rad, and the memory's state before the record."""
        return (
            *spring_parameters(_NAMES, setting),
            ModelParameter(
                "A",
                "Nm/rad",
                "stiffness of the memory after a reversal",
                "log",
                0.3 * setting.stiffness,
                1.5,
            ),
            ModelParameter(
                "beta",
                "1/rad",
                "how fast the memory fades with angle",
                "log",
                15.0 / setting.angle,
                1.2,
            ),
            initial_state("memory over A/β before the first sample, −1 to 1"),
        )

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.angle`."""
        beta = values["beta"]

        def turning(way: FloatArray) -> tuple[FloatArray, FloatArray]:
            left = np.exp(-beta * way)
            return 1 - left, beta * left

        spring = OddSpring.of(values, _NAMES, setting)
        friction = values["A"] / beta
        return angle_with_lag(course.path, spring, friction, turning, values["initial_state"])

    def inside(self, values: Values, setting: Setting) -> NDArray[np.bool_]:
        """The spring's torque grows with angle."""
        return OddSpring.of(values, _NAMES, setting).rises()

    def stiffness_curve(self, torque: FloatArray, values: Values, setting: Setting) -> FloatArray:
        """The quintic alone (A3); see `OtherModel.stiffness_curve`."""
        return OddSpring.of(values, _NAMES, setting).angle(torque)
