"""A damaged tooth: a bump of the angle at one torque, on both branches."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, signed_amplitude
from hdprog.physics.parameters import FloatArray


class ToothDamage(Effect):
    """A·exp(−½((T − T_d)/w)²): where the damaged pair meshes, both branches carry a bump."""

    id = "tooth_damage"
    words = "a bump at one torque on both branches, as a damaged tooth leaves"
    advice = "Inspect the teeth of flexspline and circular spline; do not wait for the next test."
    rivals = frozenset({"backlash"})
    unsure_advice = (
        "It may be something else: this record does not tell a damaged tooth from play in a "
        "coupling under load, or from a contact that closes late. Check flange and coupling, then "
        "inspect the teeth; a record to both signs of torque with more readings there tells more."
    )
    lasting = True
    static = True
    at_torque = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """A in rad, T_d and w in Nm."""
        top = scales.torque
        centre = EffectParameter("centre", "Nm", "torque of the bump", "between", -top, top)
        return (
            signed_amplitude("height", "of the bump", scales),
            centre.gridded(np.linspace(-0.95, 0.95, 39) * top),
            EffectParameter(
                "width",
                "Nm",
                "standard width of the bump",
                "log",
                0.04 * top,
                0.5,
                grid=(-1.0, 0.8),
            ),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        away = (course.path.torque - values["centre"]) / values["width"]
        return np.asarray(values["height"] * np.exp(-0.5 * away**2))
