"""Hyperbolic friction beside a cubic spring, after Seyfferth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.course import Course
from hdprog.physics.effects.base import initial_state
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.other_models.odd_spring import OddSpring, spring_parameters
from hdprog.physics.other_models.spring_with_lag import angle_with_lag
from hdprog.physics.parameters import FloatArray

_NAMES = ("a1", "a3")


class Seyfferth(OtherModel):
    """T = a1·Δθ + a3·Δθ³ + T_c·s, s turning from reversal to reversal as tanh(x/δ).

    Coulomb friction T_c weighted by a hyperbolic function of the angle x travelled since the last
    reversal: s = σ + (s0 − σ)(1 − tanh(x/δ)), σ the direction of motion and s0 the state at the
    reversal. The paper names the model without its equation ("a hyperbolic function, … a
    combination of Coulomb friction and a weighted friction function") and the original was not at
    hand: the hyperbolic tangent and the memory of s0 are this project's reading of that sentence.
    """

    id = "seyfferth"
    words = "Seyfferth (hyperbolic friction)"
    source = "introduction; after Seyfferth, Maghzal & Angeles, IEEE ICRA (1995)"
    where = "any record with a reversal"

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """a1, a3, T_c in Nm, δ in rad, and the friction's state before the record."""
        return (
            *spring_parameters(_NAMES, setting),
            ModelParameter("T_c", "Nm", "Coulomb friction", "log", 0.03 * setting.torque, 1.2),
            ModelParameter(
                "delta",
                "rad",
                "angle within which friction turns round",
                "log",
                0.05 * setting.angle,
                1.2,
            ),
            initial_state("friction over T_c before the first sample, −1 to 1"),
        )

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.angle`."""
        delta = values["delta"]

        def turning(way: FloatArray) -> tuple[FloatArray, FloatArray]:
            share = np.tanh(way / delta)
            return share, (1 - share * share) / delta

        spring = OddSpring.of(values, _NAMES, setting)
        return angle_with_lag(course.path, spring, values["T_c"], turning, values["initial_state"])

    def inside(self, values: Values, setting: Setting) -> NDArray[np.bool_]:
        """The spring's torque grows with angle."""
        return OddSpring.of(values, _NAMES, setting).rises()

    def stiffness_curve(self, torque: FloatArray, values: Values, setting: Setting) -> FloatArray:
        """The cubic alone; see `OtherModel.stiffness_curve`."""
        return OddSpring.of(values, _NAMES, setting).angle(torque)
