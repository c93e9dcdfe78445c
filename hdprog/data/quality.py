"""Is a record usable, and what is in it? Refusals, warnings and the facts for `hdprog check`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive
from hdprog.data.doubts import doubts
from hdprog.data.loop import Loop
from hdprog.data.noise_level import error_sd, quantisation_step
from hdprog.data.turning_points import turning_points
from hdprog.data.usable import require_numbers, require_usable

__all__ = ["Quality", "Sides", "assess", "secant_stiffness", "sides_of"]

Sides = Literal["one-sided", "two-sided"]

_TWO_SIDED_SHARE = 0.1


@dataclass(frozen=True)
class Quality:
    """What a record holds. Torques in Nm, angles in rad, times in s, temperatures in °C.

    Parameters
    ----------
    samples : int
        Number of samples.
    cycles : float
        Torque travelled, in units of a whole cycle over the torque's span.
    branches : int
        Number of stretches between turning points.
    sides : {"one-sided", "two-sided"}
        Whether the torque changes sign by more than a tenth of its largest size.
    torque_min, torque_max, angle_span : float
        Ranges.
    secant_stiffness : float
        Inverse of the regression slope of angle on torque [Nm/rad].
    duration : float or None
        From the first to the last sample, None where the record is untimed.
    loading_rates : tuple of float
        Mean size of the torque's rate in each branch [Nm/s]; empty where untimed.
    temperature_min, temperature_max : float or None
        None where no temperature was recorded.
    torque_step, angle_step : float or None
        Steps of quantisation, None where none shows.
    torque_noise, angle_noise : float
        Standard deviations of the error that the record itself shows, quantisation included.
    warnings : tuple of str
        What deserves a second look, the record's own warnings first.
    read_off : mapping
        Figures that the record shows without a model, by key; filled in by `hdprog check`.
    """

    samples: int
    cycles: float
    branches: int
    sides: Sides
    torque_min: float
    torque_max: float
    angle_span: float
    secant_stiffness: float
    duration: float | None
    loading_rates: tuple[float, ...]
    temperature_min: float | None
    temperature_max: float | None
    torque_step: float | None
    angle_step: float | None
    torque_noise: float
    angle_noise: float
    warnings: tuple[str, ...]
    read_off: Mapping[str, float] = field(default_factory=dict)


def assess(loop: Loop, drive: Drive | None = None) -> Quality:
    """Refuse a record that holds no loop; describe one that does.

    Parameters
    ----------
    loop : Loop
        The record.
    drive : Drive or None
        What is declared about the drive; torque and stiffness are compared with it.

    Returns
    -------
    Quality
        Facts and warnings.

    Raises
    ------
    BadInputError
        Fewer than 20 samples, constant torque or angle, less than one full loading and unloading,
        or an angle that falls as the torque rises.
    """
    torque = loop.torque
    require_numbers(loop)
    turns = turning_points(torque, time=loop.time)
    require_usable(loop, turns)
    travel = np.abs(np.diff(torque[turns]))
    low, high = float(torque.min()), float(torque.max())
    stiffness = secant_stiffness(loop)
    rates: tuple[float, ...] = ()
    if loop.time is not None:
        branches = pairwise(loop.time[turns].tolist())
        rates = tuple(
            float(moved) / (end - start)
            for moved, (start, end) in zip(travel, branches, strict=True)
        )
    temperature = loop.temperature
    torque_step, angle_step = quantisation_step(torque), quantisation_step(loop.angle)
    found = doubts(loop, turns, stiffness, drive)
    return Quality(
        samples=len(loop),
        cycles=float(travel.sum()) / (2.0 * (high - low)),
        branches=int(turns.size) - 1,
        sides=sides_of(torque),
        torque_min=low,
        torque_max=high,
        angle_span=float(np.ptp(loop.angle)),
        secant_stiffness=stiffness,
        duration=None if loop.time is None else float(loop.time[-1]),
        loading_rates=rates,
        temperature_min=None if temperature is None else float(temperature.min()),
        temperature_max=None if temperature is None else float(temperature.max()),
        torque_step=torque_step,
        angle_step=angle_step,
        torque_noise=error_sd(loop.torque_scatter, torque_step),
        angle_noise=error_sd(loop.angle_scatter, angle_step),
        warnings=tuple(dict.fromkeys((*loop.warnings, *found))),
    )


def sides_of(torque: NDArray[np.float64]) -> Sides:
    """Whether a torque (samples,) changes sign by more than a tenth of its largest size."""
    low, high = float(torque.min()), float(torque.max())
    both = low < 0 < high and min(-low, high) > _TWO_SIDED_SHARE * max(-low, high)
    return "two-sided" if both else "one-sided"


def secant_stiffness(loop: Loop) -> float:
    """Return the inverse slope of angle on torque [Nm/rad]; infinite where they are unrelated."""
    torque = loop.torque - loop.torque.mean()
    slope = float(torque @ (loop.angle - loop.angle.mean())) / float(torque @ torque)
    return 1.0 / slope if slope != 0.0 else np.inf
