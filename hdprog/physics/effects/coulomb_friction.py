"""Friction that does not depend on load: the loop is wider by the same angle everywhere."""

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
from hdprog.physics.lag_elements import jenkins
from hdprog.physics.parameters import FloatArray


class CoulombFriction(Effect):
    """−(w/2)·z with z the state of one Jenkins element that slips within T_c of a reversal.

    The load-independent part of the width, sign(dT/dt) in Zhang's model, with a finite pre-sliding.
    """

    id = "coulomb_friction"
    words = "the loop is wider by the same angle at every load"
    needs = frozenset({"reversal"})
    advice = (
        "Look for drag beside the teeth: seals, bearings, cables. It widens the loop but is no "
        "wear of the teeth."
    )
    lasting = True
    static = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """w in rad, T_c in Nm, initial state."""
        return (
            angle_amplitude("width", "constant part of the loop's width", scales),
            EffectParameter(
                "slip_torque",
                "Nm",
                "torque travelled from the middle until sliding",
                "log",
                0.012 * scales.torque,
                1.2,
                grid=(-1.0, 1.0),
            ),
            initial_state("state at the first sample, −1 to 1"),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        state = jenkins(course, values["slip_torque"], values["initial_state"])
        return np.asarray(-0.5 * values["width"] * state)
