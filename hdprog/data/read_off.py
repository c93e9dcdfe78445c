"""Figures read off a record itself, no drive model in between.

A figure is read from the branches of the record's cycles: straight lines through the angles near
a torque give a branch's angle there. All are sums of angles with weights, so that the same can be
read off a fitted curve at the same torques, whatever swing and history the record has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop
from hdprog.data.turning_points import turning_points
from hdprog.physics.figures import ARCMIN_PER_RAD, LOST_MOTION_SHARE, FigureRequest
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

_EXTREME = 0.8  # of the amplitude, where a branch must begin to be one of a cycle
_WHOLE = 0.9  # of the amplitude, as far as a branch must reach to close a loop
_REACH = 0.03  # of the amplitude, to either side: as far as lines are drawn
_LEAST_POINTS = 4
_LEAST_OF_A_BRANCH = 8
_EDGE = 0.02  # of the amplitude: a branch that ends so near a torque is read there
_GAP = 0.3  # of the amplitude: a branch with as wide a gap closes no loop
_USUAL_STEPS = 3.0  # from reading to reading, to a torque beside which there are none
_LEVELS = 129  # torques that the gap between the branches is summed over


@dataclass(frozen=True)
class Reading:
    """How a figure is read off the angles along a record.

    Attributes
    ----------
    weights : (samples,) whose sum with the angles in rad is an angle, or in rad Nm an area
    factor : from that sum to the figure's unit; from its inverse where it is a stiffness
    stiffness : the figure is the factor over the sum
    """

    weights: FloatArray
    factor: float
    stiffness: bool = False

    def of(self, angles: FloatArray) -> FloatArray:
        """The figure of angles (..., samples) in rad, in its own unit."""
        total = angles @ self.weights
        return np.asarray(self.factor / total if self.stiffness else self.factor * total)

    def sd(self, angles: FloatArray, covariance: FloatArray) -> float:
        """Standard deviation of the figure of angles (samples,) in rad, to first order.

        covariance : (samples, samples) of their noise in rad²
        """
        spread = float(np.sqrt(self.weights @ covariance @ self.weights))
        slope = self.factor
        if self.stiffness:
            slope /= float(angles @ self.weights) ** 2
        return abs(slope) * spread


def readings(
    path: TorquePath, requests: Sequence[FigureRequest], rated_torque: float
) -> dict[str, Reading]:
    """How those of the requested figures that a record shows are read off it, by key.

    Width, loss, lost motion and secant stiffness are read, each as the mean over the cycles and at
    the record's own swing of torque. A record of one side shows none of them.

    Parameters
    ----------
    path : torque (samples,) along the record and its stretches; blocks do as well as readings
    requests : figures of merit
    rated_torque : in Nm; lost motion is read at ± 4 % of it
    """
    branches = _Branches.of(path)
    if branches is None:
        return {}
    found = {}
    for request in requests:
        reading = _reading(branches, request, rated_torque)
        if reading is not None:
            found[request.key] = reading
    return found


def figures_of(loop: Loop, drive: Drive | None, torque_noise: float) -> dict[str, float]:
    """Width and loss that a record shows, and lost motion where the rated torque is declared.

    Parameters
    ----------
    loop : the record
    drive : what is declared of the drive
    torque_noise : standard deviation of a torque reading in Nm
    """
    rated = None if drive is None else drive.rated_torque
    requests = [FigureRequest("hysteresis_width_arcmin"), FigureRequest("hysteresis_loss_J")]
    requests += [] if rated is None else [FigureRequest("lost_motion_arcmin")]
    reduced = reduce_loop(loop, turning_points(loop.torque, time=loop.time), torque_noise)
    how = readings(reduced.path, requests, rated or 0.0)
    return {key: float(reading.of(reduced.angle)) for key, reading in how.items()}


def _reading(branches: _Branches, request: FigureRequest, rated_torque: float) -> Reading | None:
    at, factor = request.at_torque_Nm, ARCMIN_PER_RAD
    match request.quantity:
        case "hysteresis_width_arcmin":
            weights = branches.gap()
        case "hysteresis_loss_J":
            weights, factor = branches.area(), 1.0
        case "lost_motion_arcmin":
            weights = branches.middle(LOST_MOTION_SHARE * rated_torque)
        case "secant_stiffness_Nm_per_rad" if at is not None:
            weights, factor = branches.middle(at), 2 * at
        case _:
            return None
    if weights is None:
        return None
    return Reading(weights, factor, request.quantity == "secant_stiffness_Nm_per_rad")


@dataclass(frozen=True)
class _Branches:
    """Branches of a record's cycles: stretches that begin near an extreme.

    Attributes
    ----------
    torque : (samples,) of the record in Nm
    amplitude : smaller one of the largest torques to both sides in Nm
    rising, falling : samples of each branch
    """

    torque: FloatArray
    amplitude: float
    rising: tuple[slice, ...]
    falling: tuple[slice, ...]

    @staticmethod
    def of(path: TorquePath) -> _Branches | None:
        torque = path.torque
        amplitude = float(min(torque.max(), -torque.min()))
        if amplitude <= 0.0:
            return None
        rising, falling = [], []
        stretches = zip(path.starts, path.ends, path.rising, path.began, strict=True)
        for start, end, up, first in stretches:
            if end - start < _LEAST_OF_A_BRANCH:
                continue
            if up and first <= -_EXTREME * amplitude:
                rising.append(slice(int(start), int(end)))
            elif not up and first >= _EXTREME * amplitude:
                falling.append(slice(int(start), int(end)))
        return _Branches(torque, amplitude, tuple(rising), tuple(falling))

    def gap(self) -> FloatArray | None:
        """Falling minus rising branch at zero torque."""
        fall, rise = self._at(self.falling, 0.0), self._at(self.rising, 0.0)
        return None if fall is None or rise is None else fall - rise

    def middle(self, torque: float) -> FloatArray | None:
        """The mid-line at a torque minus that at the opposite one."""
        total = np.zeros(self.torque.size)
        for branches in (self.rising, self.falling):
            above, below = self._at(branches, torque), self._at(branches, -torque)
            if above is None or below is None:
                return None
            total += 0.5 * (above - below)
        return total

    def area(self) -> FloatArray | None:
        """The area between the branches, as far as all of them reach."""
        whole = [
            [branch for branch in branches if self._is_whole(branch)]
            for branches in (self.rising, self.falling)
        ]
        if not all(whole):
            return None
        every = [self.torque[branch] for branches in whole for branch in branches]
        ends = max(part.min() for part in every), min(part.max() for part in every)
        levels = np.linspace(*ends, _LEVELS)
        step = np.full(_LEVELS, levels[1] - levels[0])
        step[[0, -1]] /= 2
        total = np.zeros(self.torque.size)
        for branches, sign in zip(whole, (-1.0, 1.0), strict=True):
            for branch in branches:
                shares = _between(self.torque[branch], levels, step)
                total[branch] += sign / len(branches) * shares
        return total

    def _is_whole(self, branch: slice) -> bool:
        part, needed = np.sort(self.torque[branch]), _WHOLE * self.amplitude
        gapless = np.diff(part).max() <= _GAP * self.amplitude
        return bool(gapless and part[0] <= -needed and part[-1] >= needed)

    def _misses(self, part: FloatArray, torque: float) -> bool:
        """Whether a branch has no readings about a torque that it passes, and others elsewhere."""
        usual = float(np.median(np.abs(np.diff(part))))
        near = max(_REACH * self.amplitude, _USUAL_STEPS * usual)
        return bool(np.sort(np.abs(part - torque))[1] > near)

    def _at(self, branches: Sequence[slice], torque: float) -> FloatArray | None:
        """Mean angle at a torque of the branches that reach it, as weights (samples,)."""
        edge = _EDGE * self.amplitude
        reaching = [
            branch
            for branch in branches
            if self.torque[branch].min() - edge <= torque <= self.torque[branch].max() + edge
            and not self._misses(self.torque[branch], torque)
        ]
        if not reaching:
            return None
        total = np.zeros(self.torque.size)
        for branch in reaching:
            line = _line(self.torque[branch] - torque, _REACH * self.amplitude)
            total[branch] += line / len(reaching)
        return total


def _line(distance: FloatArray, reach: float) -> FloatArray:
    """Weights (samples,) of a straight line's value where the distance in torque is zero."""
    near = np.abs(distance) <= reach
    if near.sum() < _LEAST_POINTS:
        near = np.zeros(distance.size, dtype=bool)
        near[np.argsort(np.abs(distance), kind="stable")[:_LEAST_POINTS]] = True
    weights = np.zeros(distance.size)
    columns = np.column_stack([np.ones(int(near.sum())), distance[near] / reach])
    weights[near] = np.linalg.pinv(columns)[0]
    return weights


def _between(torque: FloatArray, levels: FloatArray, step: FloatArray) -> FloatArray:
    """Weights (samples,) of a branch's area: its angles between samples, summed over levels."""
    order = np.argsort(torque, kind="stable")
    known = torque[order]
    right = np.clip(np.searchsorted(known, levels), 1, known.size - 1)
    width = known[right] - known[right - 1]
    share = np.where(width > 0, (levels - known[right - 1]) / np.where(width > 0, width, 1.0), 1.0)
    weights = np.zeros(torque.size)
    np.add.at(weights, order[right - 1], step * (1 - share))
    np.add.at(weights, order[right], step * share)
    return weights
