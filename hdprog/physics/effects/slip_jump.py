"""A sudden lasting step of the angle at one instant."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, signed_amplitude
from hdprog.physics.parameters import FloatArray


class SlipJump(Effect):
    """J·½(1 + tanh((t − t_j)/d)): something slipped once, at t_j, within a short time d."""

    id = "slip_jump"
    words = "a sudden lasting step of the angle at one instant"
    advice = (
        "Something slipped: check the clamping of drive, coupling and encoder; repeat the test."
    )

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """J in rad, t_j and d in parts of the record."""
        when = EffectParameter("instant", "of the record", "of the step", "between", 0.0, 1.0)
        return (
            signed_amplitude("step", "lasting change of the angle", scales),
            when.gridded(np.linspace(0.02, 0.98, 97)),
            EffectParameter("duration", "of the record", "of the step", "log", 0.004, 0.7),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        after = (course.clock - values["instant"]) / values["duration"]
        return np.asarray(values["step"] * 0.5 * (1 + np.tanh(after)))
