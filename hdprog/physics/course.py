"""What happened along a record, as effects beside the drive model see it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath
from hdprog.physics.warm_up import WarmUp


@dataclass(frozen=True)
class Scales:
    """Scales of a record that the priors of effects are centred on.

    Attributes
    ----------
    torque : largest torque in Nm
    angle : half the range of the torsion angle in rad
    rate : loading rate in Nm/s that 2 % of the readings exceed; None for an untimed record
    duration : in s; None for an untimed record
    sweep : range of the absolute output position in rad; None where it was not recorded
    output_middle : mean absolute output position in rad, from which its lines' phases count; None
        where it was not recorded
    warm_up : nearest to the temperature; None where it was not recorded or hardly moves
    angle_step : resolution of the angle's readings in rad; None where none shows
    angle_error : standard deviation of their error beside such steps, these included, in rad
    readings : number of values along the record, which bounds what frequency can be seen
    """

    torque: float
    angle: float
    rate: float | None
    duration: float | None
    sweep: float | None
    readings: int
    output_middle: float | None = None
    warm_up: WarmUp | None = None
    angle_step: float | None = None
    angle_error: float | None = None


@dataclass(frozen=True)
class Course:
    """A record's coordinates in the order of recording, (samples,) each.

    Attributes
    ----------
    path : torque history
    order : place in the record, from 0 to 1
    time : in s from the record's start, or None
    rate : loading rate dT/dt from a denoised torque in Nm/s, or None
    temperature : denoised, in °C, or None
    output_angle : absolute output position in rad, or None
    scales : of the record
    output_speed : its rate in rad/s from a smoothed position, or None
    """

    path: TorquePath
    order: FloatArray
    time: FloatArray | None
    rate: FloatArray | None
    temperature: FloatArray | None
    output_angle: FloatArray | None
    scales: Scales
    output_speed: FloatArray | None = None

    @staticmethod
    def of_torque(path: TorquePath, scales: Scales) -> Course:
        """Course of which the torque alone is known, evenly through the order of recording."""
        order = np.linspace(0.0, 1.0, path.torque.size)
        return Course(path, order, None, None, None, None, scales)

    @cached_property
    def load(self) -> FloatArray:
        """(samples,) torque over the record's largest."""
        return self.path.torque / self.scales.torque

    @cached_property
    def clock(self) -> FloatArray:
        """(samples,) time from 0 to 1 over the record; the order where it is untimed."""
        if self.time is None or self.scales.duration is None:
            return self.order
        return self.time / self.scales.duration

    @cached_property
    def temperature_beside(self) -> FloatArray | None:
        """(samples,) what the temperature does beside its warm-up, by the record's own scale.

        None where it tells nothing.
        """
        if self.temperature is None or self.scales.warm_up is None:
            return None
        return self.scales.warm_up.beside(self.clock, self.temperature)

    @cached_property
    def turned_at(self) -> FloatArray:
        """(samples,) torque at the last reversal (or at the record's start) in Nm."""
        return np.repeat(self.path.began, self.path.lengths)

    @cached_property
    def travel(self) -> FloatArray:
        """(samples,) torque travelled since the last reversal in Nm."""
        return np.maximum((self.path.torque - self.turned_at) * self.path.direction, 0.0)

    @cached_property
    def spans(self) -> FloatArray:
        """(stretches,) torque travelled by the end of each stretch in Nm."""
        return np.abs(self.path.reached - self.path.began)

    def corrected(self, error: FloatArray, error_reached: FloatArray) -> TorquePath:
        """The torque path with an error of the torque sensor taken out.

        Parameters
        ----------
        error : (draws, samples) in Nm
        error_reached : (draws, stretches) at the stretches' ends in Nm
        """
        return replace(
            self.path,
            torque=self.path.torque - error,
            reversal_torque=self.path.reached - error_reached,
        )
