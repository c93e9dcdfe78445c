"""Hysteresis width and local stiffness of any model, on a steady cycle inside the record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

POINTS = 24
"""Points of the stiffness curves from zero to the cycle's torque, or on either side of it."""

Angles = Callable[[Course], FloatArray]
"""Angles (draws, samples) of a model's draws along a course."""


@dataclass(frozen=True)
class SteadyCycle:
    """A cycle that a record covers, so that no model is asked for what it has not seen.

    Attributes
    ----------
    low, high : its ends in Nm, one of them zero for a one-sided record
    scales : of the record
    speed : typical speed of the output in rad/s, or None where it is not known
    """

    low: float
    high: float
    scales: Scales
    speed: float | None

    @staticmethod
    def of(course: Course, reference_torque: float) -> SteadyCycle:
        """Cycle to the reference torque, or to the record's largest where that is less."""
        torque, largest = course.path.torque, course.scales.torque
        # The far ends of a record may be spikes: what one sample in two hundred passes is its end.
        low, high = (float(np.quantile(torque, share)) for share in (0.005, 0.995))
        top = min(reference_torque, largest)
        speed = course.output_speed
        typical = None if speed is None else float(np.median(np.abs(speed)))
        if min(high, -low) > 0.2 * largest:
            top = min(top, high, -low)
            return SteadyCycle(-top, top, course.scales, typical)
        if high > -low:
            return SteadyCycle(0.0, min(top, high), course.scales, typical)
        return SteadyCycle(-min(top, -low), 0.0, course.scales, typical)

    @property
    def two_sided(self) -> bool:
        """Whether both signs of torque are in it."""
        return self.low < 0 < self.high

    @property
    def amplitude(self) -> float:
        """Its largest torque in Nm."""
        return max(self.high, -self.low)

    @property
    def width_torque(self) -> float:
        """Where the width is read: at no load, in the middle of a one-sided cycle."""
        return 0.0 if self.two_sided else 0.5 * (self.low + self.high)

    @property
    def edges(self) -> FloatArray:
        """(edges,) torques between which the local stiffness is a mean."""
        count = 2 * POINTS if self.two_sided else POINTS
        return np.linspace(self.low, self.high, count + 1)

    def branches(self, torque: FloatArray, angles: Angles) -> tuple[FloatArray, FloatArray]:
        """Angle on the rising and the falling branch at rising torques (samples,).

        Returns
        -------
        two (draws, samples) arrays in rad
        """
        # Two rounds come before: what was before the first does not matter any more.
        rounds = [0.0, self.high, self.low, self.high, self.low]
        history = np.concatenate([rounds, torque, [self.high], torque[::-1]])
        found = angles(self._course(history))
        count = torque.size
        rising = found[:, len(rounds) : len(rounds) + count]
        return rising, found[:, -1 : -1 - count : -1]

    def _course(self, torque: FloatArray) -> Course:
        path = TorquePath.exact(torque)
        moving = self.speed is not None
        middle = self.scales.output_middle or 0.0
        return Course(
            path=path,
            order=np.linspace(0.0, 1.0, torque.size),
            time=np.arange(torque.size, dtype=float) if moving else None,
            rate=None,
            temperature=None,
            output_angle=np.full(torque.size, middle) if moving else None,
            scales=self.scales,
            output_speed=path.direction * self.speed if self.speed is not None else None,
        )


def local_stiffness(edges: FloatArray, curve: FloatArray) -> FloatArray | None:
    """Mean dT/dΔθ between edges (edges,) in Nm of curves (draws, edges) in rad: (draws, edges − 1).

    None for a model that does not yield.
    """
    rise = np.diff(curve, axis=1)
    if not (rise > 0).any():
        return None
    with np.errstate(divide="ignore"):
        return np.asarray(np.where(rise > 0, np.diff(edges) / rise, np.nan))
