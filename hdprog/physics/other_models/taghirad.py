"""Structural damping beside a cubic spring, after Taghirad."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.course import Course
from hdprog.physics.drive_model import play
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.other_models.odd_spring import OddSpring, spring_parameters
from hdprog.physics.parameters import FloatArray

_NAMES = ("a1", "a3")
_NODES = np.sign(np.linspace(-1, 1, 513)) * np.linspace(-1, 1, 513) ** 2  # denser about no load
_LEAST, _MOST = 0.3, 2.0  # of the exponent
_SLOPE = 1e-9  # of the stiffness: keeps a curve that stands still invertible


class Taghirad(OtherModel):
    """T = a1·Δθ + a3·Δθ³ + D·|Δθ/θ_m|^p·sign(dΔθ/dt).

    The damping torque grows with the twist, whatever the speed. θ_m is the record's angle at its
    largest torque, so that D is the damping torque there (and beyond). At a reversal the sign turns
    round: torque has to come back by twice the damping torque before the angle moves, so the angle
    is a play between the two branches. With p < 1 it jumps through zero where torque changes sign.
    The paper names the model without its equation; the form |Δθ|^p·sign is that of Taghirad's
    compliance model as the literature cites it, checked against no original.
    """

    id = "taghirad"
    words = "Taghirad (structural damping)"
    source = "introduction; after Taghirad & Bélanger, ASME J. Dyn. Syst. Meas. Control 120 (1998)"
    where = "any record with a reversal; p only where the loop's width over torque shows it"

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """a1, a3, D in Nm, p, and where the angle stood before the record."""
        return (
            *spring_parameters(_NAMES, setting),
            ModelParameter(
                "D", "Nm", "damping torque at full load", "log", 0.03 * setting.torque, 1.2
            ),
            ModelParameter("p", "-", "its growth with the angle", "between", _LEAST, _MOST),
            ModelParameter(
                "initial_state",
                "-",
                "place between the branches before the first sample, 0 to 1",
                "between",
                0.0,
                1.0,
            ),
        )

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.angle`."""
        path = course.path
        nodes, loading = _loading_branch(values, setting)
        pushing = np.stack([np.interp(path.pushing, row, nodes) for row in loading])
        envelope, at_end, lower, upper = path.parted(pushing)
        first = lower + values["initial_state"][:, 0] * (upper - lower)
        return play(path, envelope, at_end, first)

    def inside(self, values: Values, setting: Setting) -> NDArray[np.bool_]:
        """Torque grows with angle on both branches, where the twist is more than a tenth."""
        spring = OddSpring.of(values, _NAMES, setting)
        size = np.linspace(0.1, 1.0, 19)
        slope = spring.slope(setting.angle * np.broadcast_to(size, (len(values["p"]), size.size)))
        loss = values["D"] * values["p"] * size ** (values["p"] - 1) / setting.angle
        return np.asarray(spring.rises() & (slope > loss).all(axis=1))

    def stiffness_curve(self, torque: FloatArray, values: Values, setting: Setting) -> FloatArray:
        """The cubic alone; see `OtherModel.stiffness_curve`."""
        return OddSpring.of(values, _NAMES, setting).angle(torque)


def _loading_branch(values: Values, setting: Setting) -> tuple[FloatArray, FloatArray]:
    """Angles (nodes,) in rad and torques (draws, nodes) in Nm of rising angle.

    The unloading branch is its mirror image. Where the branch would fall, torque stands still.
    """
    spring = OddSpring.of(values, _NAMES, setting)
    nodes = 2 * setting.angle * _NODES
    at = np.broadcast_to(nodes, (len(values["D"]), nodes.size))
    damping = values["D"] * np.minimum(np.abs(at / setting.angle), 1.0) ** values["p"]
    torque = np.maximum.accumulate(spring.torque(at) + damping, axis=1)
    return nodes, torque + _SLOPE * values["a1"] * nodes
