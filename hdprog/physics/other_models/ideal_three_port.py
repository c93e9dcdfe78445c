"""The ideal gear: rigid, without friction (eqs 1-5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.course import Course
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.parameters import FloatArray


class IdealThreePort(OtherModel):
    """θ_WG = (N+1)·θ_CS − N·θ_FS and T_WG = T_CS/(N+1) = −T_FS/N (1, 2).

    With the wave generator locked and the circular spline fixed the flexspline does not move: the
    torsion angle is zero at every torque. As a competitor it is the scale that others count from.
    """

    id = "ideal"
    words = "ideal three-port gear"
    source = "eqs 1-5; Tuttle & Seering, IEEE Trans. Robotics and Automation 12 (1996) 368"
    where = "any record; it has nothing to fit"
    hysteresis = False

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """None."""
        return ()

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """Zero, (1, samples)."""
        return np.zeros((1, course.path.torque.size))

    def inside(self, values: Values, setting: Setting) -> NDArray[np.bool_]:
        """See `OtherModel.inside`."""
        return np.ones(1, dtype=bool)


def gear_ratio(teeth_flexspline: int, teeth_circular_spline: int) -> float:
    """Reduction ratio N = Z_FS/(Z_CS − Z_FS) (3)."""
    return teeth_flexspline / (teeth_circular_spline - teeth_flexspline)


def wave_generator_angle(
    circular_spline: FloatArray, flexspline: FloatArray, ratio: float
) -> FloatArray:
    """Angle of the wave generator in rad from those of the other ports (...) in rad (1, 4)."""
    return np.asarray((ratio + 1) * circular_spline - ratio * flexspline)


def port_torques(flexspline: FloatArray, ratio: float) -> tuple[FloatArray, FloatArray]:
    """Torques of wave generator and circular spline in Nm from the flexspline's (2, 5).

    What the wave generator takes in the other two give out:
    T_WG·dθ_WG = T_CS·dθ_CS + T_FS·dθ_FS.
    """
    wave_generator = -np.asarray(flexspline) / ratio
    return wave_generator, (ratio + 1) * wave_generator
