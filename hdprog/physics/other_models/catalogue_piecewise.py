"""The makers' catalogue stiffness: three straight pieces (eq. 8)."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.parameters import FloatArray


class CataloguePiecewise(OtherModel):
    """Δθ = T/K1 up to T1, slope 1/K2 up to T2, slope 1/K3 beyond, mirrored for T < 0 (8).

    T1 and T2 are the maker's where the drive names its catalogue entry; else they are fitted, T2 as
    T1 plus a width. The equation has no friction.
    """

    id = "catalogue_piecewise"
    words = "catalogue piecewise-linear"
    source = "eq. 8; makers' catalogues"
    where = "any record; K2 and K3 only as far as the torque goes beyond T1 and T2"
    hysteresis = False

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """K1, K2, K3 in Nm/rad; T1 and the width T2 − T1 in Nm unless the catalogue gives them."""
        stiffnesses = tuple(
            ModelParameter(name, "Nm/rad", meaning, "log", setting.stiffness, 1.0)
            for name, meaning in (
                ("K1", "stiffness up to T1"),
                ("K2", "stiffness from T1 to T2"),
                ("K3", "stiffness beyond T2"),
            )
        )
        if setting.catalogue_torques is not None:
            return stiffnesses
        return (
            *stiffnesses,
            ModelParameter("T1", "Nm", "first threshold", "between", 0.0, setting.torque),
            ModelParameter("T2_T1", "Nm", "second less first", "between", 0.0, setting.torque),
        )

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.angle`."""
        return self.stiffness_curve(course.path.torque, values, setting)

    def stiffness_curve(self, torque: FloatArray, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.stiffness_curve`."""
        if setting.catalogue_torques is not None:
            first, second = (np.array([[edge]]) for edge in setting.catalogue_torques)
        else:
            first, second = values["T1"], values["T1"] + values["T2_T1"]
        size = np.abs(torque)
        angle = np.minimum(size, first) / values["K1"]
        angle = angle + np.clip(size - first, 0.0, second - first) / values["K2"]
        angle += np.maximum(size - second, 0.0) / values["K3"]
        return np.asarray(np.copysign(angle, torque))
