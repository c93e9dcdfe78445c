"""Play: a step of the torsion angle where the torque changes sign."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, angle_amplitude
from hdprog.physics.parameters import FloatArray


class Backlash(Effect):
    """(δ/2)·tanh(T/T_s): flanks change sides within ± T_s.

    The smooth form of a dead zone; e.g. Kolnik and Agranovich, IEEE 27th Convention of Electrical
    and Electronics Engineers in Israel (2012), for harmonic drives.
    """

    id = "backlash"
    words = "a step of the angle where the torque changes sign"
    needs = frozenset({"both signs of torque"})
    advice = (
        "Check the fixing of flange and coupling and tighten them; if the step stays, the teeth "
        "are worn: plan a replacement."
    )
    lasting = True
    static = True
    at_torque = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """δ in rad, T_s in Nm."""
        return (
            angle_amplitude("play", "step of the angle from side to side", scales),
            EffectParameter(
                "width",
                "Nm",
                "torque within which the sides change",
                "log",
                0.012 * scales.torque,
                0.7,
                grid=(-1.2, 0.0, 1.2),
            ),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        return np.asarray(0.5 * values["play"] * np.tanh(course.path.torque / values["width"]))
