"""Zhang's springs in series, one behind a constant friction (A4)."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course
from hdprog.physics.drive_model import play
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.parameters import FloatArray


class Zhang(OtherModel):
    """Δθ = arctan(C_F·T)/(C_F·K_F0) + sign(T_w)·(1 − exp(−C_w|T_w|))/(C_w·K_w0) (A4).

    T_w is the torque that comes through to the wave generator past a constant friction F_f. Written
    at the output's side: with the paper's constants, C_w here is C_w/N and K_w0 is N²·K_w0, since N
    cannot be told from a loop with the input locked; T_w counts in the direction of T. On a cycle
    T_w = T ∓ F_f; behind a reversal it stays until torque has come back by 2·F_f, as a spring
    behind a constant friction does: a play operator, which defines every other history as well.
    """

    id = "zhang"
    words = "Zhang (springs in series)"
    source = "A4; Zhang et al., the paper's reference 10"
    where = "any record with a reversal"

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """K_F0, K_w0 in Nm/rad; C_F, C_w in 1/Nm; F_f in Nm; the state before the record."""
        stiffness, curvature = 2 * setting.stiffness, 0.3 / setting.torque
        return (
            ModelParameter("K_F0", "Nm/rad", "flexspline at no load", "log", stiffness, 1.0),
            ModelParameter("C_F", "1/Nm", "hardening of the flexspline", "log", curvature, 1.5),
            ModelParameter("K_w0", "Nm/rad", "wave generator at no load", "log", stiffness, 1.2),
            ModelParameter("C_w", "1/Nm", "hardening of the wave generator", "log", curvature, 1.5),
            ModelParameter(
                "F_f",
                "Nm",
                "friction before the wave generator",
                "log",
                0.03 * setting.torque,
                1.2,
            ),
            ModelParameter(
                "initial_state",
                "-",
                "place between the bounds before the first sample, 0 to 1",
                "between",
                0.0,
                1.0,
            ),
        )

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.angle`."""
        path, friction = course.path, values["F_f"]
        envelope, at_end, _, _ = path.parted(path.pushing - friction)
        first = path.torque[0] + friction[:, 0] * (2 * values["initial_state"][:, 0] - 1)
        through = play(path, envelope, at_end, first)
        return _series(path.torque, through, values)

    def stiffness_curve(self, torque: FloatArray, values: Values, setting: Setting) -> FloatArray:
        """(A4) with F_f = 0; see `OtherModel.stiffness_curve`."""
        return _series(torque, torque[None, :], values)


def _series(torque: FloatArray, through: FloatArray, values: Values) -> FloatArray:
    """Flexspline under the torque and wave generator under what comes through, in rad."""
    flexspline = np.arctan(values["C_F"] * torque) / (values["C_F"] * values["K_F0"])
    size = -np.expm1(-values["C_w"] * np.abs(through)) / (values["C_w"] * values["K_w0"])
    return np.asarray(flexspline + np.copysign(size, through))
