"""Friction that falls with speed."""

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

_SLIP = 0.012  # of the largest torque: within it of a reversal the friction has turned round


class StribeckFriction(Effect):
    """−(w/2)·z·exp(−(|dT/dt|/r_s)^p): the falling part of the friction curve (10).

    z is the state of a Jenkins element, ± 1 while it slides, so that friction turns round within a
    short travel after a reversal. Measured powers p lie between 0.5 and 2 (Armstrong-Hélouvry,
    Dupont and Canudas de Wit, Automatica 30 (1994) 1083).
    """

    id = "stribeck_friction"
    words = "the loop is narrower the faster it is run"
    needs = frozenset({"time", "several loading rates"})
    advice = (
        "Compare tests only at one loading rate; a growing value points to boundary lubrication: "
        "check the grease."
    )
    lasting = True
    divides_width = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """w in rad, r_s in Nm/s, p, initial state."""
        fastest = scales.rate if scales.rate is not None else 1.0
        return (
            angle_amplitude("width", "width of the loop added at rest", scales),
            EffectParameter(
                "stribeck_rate",
                "Nm/s",
                "loading rate at which that width falls to 1/e",
                "log",
                0.15 * fastest,
                0.8,
                grid=(-1.0, 0.0, 1.0),
            ),
            EffectParameter("exponent", "-", "power of the rate", "log", 1.0, 0.4),
            initial_state("state at the first sample, −1 to 1"),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        assert course.rate is not None
        limit = np.full_like(values["width"], _SLIP * course.scales.torque)
        state = jenkins(course, limit, values["initial_state"])
        speed = np.abs(course.rate) / values["stribeck_rate"]
        fading = np.exp(-(speed ** values["exponent"]))
        return np.asarray(-0.5 * values["width"] * state * fading)
