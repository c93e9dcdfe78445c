"""Zero error of the torque sensor: T_true = T − T_z, the loop shifted along torque."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, either_sign
from hdprog.physics.parameters import FloatArray


class TorqueOffset(Effect):
    """The torque reading is too high by T_z throughout.

    T_true = T − T_z; the drive model is odd in torque, so a two-sided loop shows it.
    """

    id = "torque_offset"
    words = "zero error of the torque sensor"
    acts_on = "torque"
    needs = frozenset({"both signs of torque"})
    advice = "Set the torque sensor's zero with the joint unloaded, then repeat the test."

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """T_z in Nm."""
        meaning = "torque reading at no torque"
        return (either_sign("zero_torque", "Nm", meaning, 0.003 * scales.torque),)

    def torque_error(self, course: Course, values: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.torque_error`."""
        along = np.ones((1, course.path.torque.size))
        return values["zero_torque"] * along, values["zero_torque"] * np.ones(
            (1, course.path.starts.size)
        )
