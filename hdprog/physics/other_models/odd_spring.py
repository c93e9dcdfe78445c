"""A spring whose torque is an odd polynomial of its angle, and its inverse.

Beyond a largest angle, which the record does not reach, the curve goes on along its tangent: a
softening spring would otherwise have torques that no angle gives.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.other_models.base import ModelParameter, Setting, Values
from hdprog.physics.parameters import FloatArray

_REACH = 1.15  # of the record's angle at its largest torque
_NODES = 129
_STEPS = 2  # of Newton's method behind the table: to rounding
_BEND = 0.1  # of the torque at full load that a bending term typically carries


@dataclass(frozen=True)
class OddSpring:
    """T = c1·θ + c3·θ³ + c5·θ⁵ up to a largest angle, straight beyond.

    Attributes
    ----------
    c1, c3, c5 : (draws, 1) in Nm/rad, Nm/rad³, Nm/rad⁵
    reach : largest angle of the polynomial in rad
    """

    c1: FloatArray
    c3: FloatArray
    c5: FloatArray
    reach: float

    @staticmethod
    def of(values: Values, names: tuple[str, ...], setting: Setting) -> OddSpring:
        """From two or three coefficients by their names."""
        c1, c3, *rest = (values[name] for name in names)
        c5 = rest[0] if rest else np.zeros_like(c1)
        return OddSpring(c1, c3, c5, _REACH * setting.angle)

    @cached_property
    def _at_reach(self) -> tuple[FloatArray, FloatArray]:
        """Torque and slope at the largest angle, (draws, 1)."""
        square = self.reach**2
        torque = self.reach * (self.c1 + square * (self.c3 + square * self.c5))
        return torque, self.c1 + square * (3 * self.c3 + square * 5 * self.c5)

    def torque(self, angle: FloatArray) -> FloatArray:
        """Torque in Nm at angles (draws, samples) in rad."""
        size = np.abs(angle)
        within = np.minimum(size, self.reach)
        square = within * within
        torque = within * (self.c1 + square * (self.c3 + square * self.c5))
        torque += (size - within) * self._at_reach[1]
        return np.asarray(np.copysign(torque, angle))

    def slope(self, angle: FloatArray) -> FloatArray:
        """Stiffness in Nm/rad at angles (draws, samples) in rad."""
        square = np.minimum(np.abs(angle), self.reach) ** 2
        return np.asarray(self.c1 + square * (3 * self.c3 + square * 5 * self.c5))

    def angle(self, torque: FloatArray) -> FloatArray:
        """Angle (draws, samples) in rad at torques (samples,) or (draws, samples) in Nm."""
        draws = self.c1.shape[0]
        torque = np.broadcast_to(torque, (draws, torque.shape[-1]))
        size = np.abs(torque)
        nodes = np.linspace(0.0, self.reach, _NODES)
        table = self.torque(np.broadcast_to(nodes, (draws, _NODES)))
        angle = np.stack([np.interp(one, row, nodes) for one, row in zip(size, table, strict=True)])
        at_reach, slope = self._at_reach
        angle += np.maximum(size - at_reach, 0.0) / slope
        for _ in range(_STEPS):
            angle -= (self.torque(angle) - size) / self.slope(angle)
        return np.asarray(np.copysign(angle, torque))

    def rises(self) -> NDArray[np.bool_]:
        """(draws,) whether torque grows with angle everywhere."""
        # The slope is a parabola in the square of the angle: its ends and its lowest point.
        top = self.reach**2
        with np.errstate(divide="ignore", invalid="ignore"):
            lowest = np.nan_to_num(-3 * self.c3 / (10 * self.c5), posinf=top, neginf=0.0)
        at = np.hstack(
            [np.zeros_like(self.c1), np.clip(lowest, 0.0, top), np.full_like(lowest, top)]
        )
        slope = self.c1 + at * (3 * self.c3 + 5 * self.c5 * at)
        return np.asarray((slope > 0).all(axis=1))


def spring_parameters(names: tuple[str, ...], setting: Setting) -> tuple[ModelParameter, ...]:
    """Stiffness at no load, and terms of third (and fifth) order of either sign."""
    units = ("Nm/rad", "Nm/rad³", "Nm/rad⁵")
    found = [
        ModelParameter(names[0], units[0], "stiffness at no load", "log", setting.stiffness, 1.0)
    ]
    for index, name in enumerate(names[1:], start=1):
        typical = _BEND * setting.stiffness / setting.angle ** (2 * index)
        order = "third" if index == 1 else "fifth"
        found.append(
            ModelParameter(
                name, units[index], f"hardening of {order} order", "signed", typical, 2.0
            )
        )
    return tuple(found)
