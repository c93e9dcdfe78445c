"""Play: a step of the torsion angle where the load changes sides, at or near zero torque."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, angle_amplitude
from hdprog.physics.parameters import FloatArray

_CENTRES = np.array([-0.25, -0.16, -0.1, -0.06, -0.03, 0.0, 0.03, 0.06, 0.1, 0.16, 0.25])


class Backlash(Effect):
    """(δ/2)·tanh((T − T_c)/T_s): flanks change sides within ± T_s about T_c.

    T_c is near zero, but for a load beside the measured torque, such as the weight of an arm or the
    preload of a coupling. The smooth form of a dead zone; e.g. Kolnik and Agranovich, IEEE 27th
    Convention of Electrical and Electronics Engineers in Israel (2012), for harmonic drives.
    """

    id = "backlash"
    words = "a step of the angle where the load changes sides"
    needs = frozenset({"both signs of torque"})
    advice = (
        "Check the fixing of flange and coupling and tighten them; if the step stays, the teeth "
        "are worn: plan a replacement."
    )
    lasting = True
    static = True
    at_torque = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """δ in rad, T_s and T_c in Nm."""
        top = scales.torque
        centre = EffectParameter(
            "centre", "Nm", "torque about which the sides change", "signed", 0.001 * top, 2.0
        )
        return (
            angle_amplitude("play", "step of the angle from side to side", scales),
            EffectParameter(
                "width",
                "Nm",
                "torque within which the sides change",
                "log",
                0.012 * top,
                0.7,
                grid=(-1.2, 0.0, 1.2, 2.4),
            ),
            centre.gridded(_CENTRES * top),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        away = course.path.torque - values["centre"]
        return np.asarray(0.5 * values["play"] * np.tanh(away / values["width"]))
