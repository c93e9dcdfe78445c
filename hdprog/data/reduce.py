"""Long records reduced along the path: block averages between exact reversals.

Blocks hold about equal shares of torque travelled and of readings, never cross a reversal, and
carry the variance of torque inside them, so that a fit costs the same for any file length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

MAX_BLOCKS = 300
MOST_BLOCKS = 600
"""Blocks that a record of many readings has at most, but where it holds several cycles."""
_LEAST_BLOCKS = 400
_READINGS_TO_THEM = 3000  # beyond, blocks grow with the cube root of readings, to twice as many
_LEAST_A_STRETCH = 14
_BLOCKS_A_STRETCH = 75  # a stretch has its own corners to resolve
_BLOCKS_A_SPAN = 130  # for each time that torque crosses its range: one cycle has the least then
_MOST_OF_CYCLES = 1200
FINE = 24
"""Points of a block along which a model's bend inside it is averaged."""
_TELLING = 20  # readings from which the rate of a ramp is known
_NARROW = 0.06  # of the largest torque: the reach of the shorter blocks around zero
_DENSER = 4.0
_TRAVEL_SHARE = (
    0.7  # the rest of a block's length is counted in readings, so that holds have blocks
)
_DETAIL_SHARE = 0.7  # of the blocks, once it is known where detail is wanted


@dataclass(frozen=True)
class ReducedLoop:
    """A record as the likelihood sees it.

    Attributes
    ----------
    course : coordinates over the blocks, means of their readings; reversals exact
    angle : (blocks,) mean angle in rad
    count : (blocks,) readings in each block
    position : (blocks,) mean index of a block's readings in the record
    block_of : (samples,) block of every reading; −1 where it was set aside
    """

    course: Course
    angle: FloatArray
    count: FloatArray
    position: FloatArray
    block_of: NDArray[np.intp]

    @property
    def inside(self) -> TorquePath:
        """Path through `FINE` torques of each block, even, with the block's mean and variance."""
        path = self.course.path
        if path.variance is None:
            return path
        spread = np.sqrt(12 * path.variance) * path.direction
        at = (np.arange(FINE) + 0.5) / FINE - 0.5
        # So many points in a row have a variance that is smaller by this factor than a ramp's.
        at /= np.sqrt(1 - 1 / FINE**2)
        return replace(
            path,
            torque=(path.torque[:, None] + spread[:, None] * at).ravel(),
            starts=path.starts * FINE,
            variance=None,
        )

    @property
    def path(self) -> TorquePath:
        """Torque path over the blocks."""
        return self.course.path

    @property
    def time(self) -> FloatArray | None:
        """(blocks,) mean time in s, or None."""
        return self.course.time

    @property
    def moment(self) -> FloatArray:
        """(blocks,) when they were recorded: in s, or in readings where no time is known."""
        return self.position if self.time is None else self.time


def _window(torque: FloatArray, noise: float) -> float:
    """Readings of a ramp to average at its end: as many as make the bias no larger than the noise.

    Infinite where the ramp is too short to tell.
    """
    rate = float(np.mean(np.abs(torque - torque[-1]))) / max(1, torque.size) * 2
    if torque.size < _TELLING:
        return np.inf
    return float((4 * noise / max(rate, 1e-12)) ** (2 / 3))


def _reversal_torques(
    torque: FloatArray, turning_points: NDArray[np.intp], noise: float
) -> FloatArray:
    """Denoised torque at the end of every stretch, (stretches,) in Nm."""
    torques = np.empty(turning_points.size - 1)
    following = np.append(turning_points[2:], turning_points[-1])
    windows = [_window(torque[start : end + 1], noise) for start, end in pairwise(turning_points)]
    for number, (start, end) in enumerate(pairwise(turning_points)):
        size = end + 1 - start
        # Readings of both ramps are averaged: the steeper one bounds how many.
        wanted = min(windows[number : number + 2]) if size >= _TELLING else 1.0
        half = int(np.clip(wanted, 1, max(1, size // 40))) // 2
        # Of a ramp of fewer than three readings no line is known: there the reading stands.
        if half == 0 and start <= end - 3 and end + 3 <= following[number]:
            torques[number] = _corner(torque[end - 3 : end + 4], noise)
            continue
        after = min(end + half, torque.size - 1)
        torques[number] = np.mean(torque[max(start, end - half) : after + 1])
    return torques


def _corner(near: FloatArray, noise: float) -> float:
    """Torque of a sharp corner that fell between two readings, where the ramps' lines meet.

    A rounded corner, or one with a hold, has no such lines: there the reading stands.

    Parameters
    ----------
    near : (7,) readings about the last one before the reversal, which is in the middle
    noise : standard deviation of a reading in Nm
    """
    slope_before, level_before = np.polyfit([-2.0, -1.0, 0.0], near[1:4], 1)
    slope_after, level_after = np.polyfit([1.0, 2.0, 3.0], near[4:], 1)
    step = max(abs(slope_before), abs(slope_after))
    # A rounded corner bends towards the reversal on both sides; ramps that are uneven, at random.
    bend = np.sign(slope_after) * (np.diff(near[1:4], 2)[0] + np.diff(near[4:], 2)[0]) / 2
    if bend > 4 * noise + 0.2 * step or slope_before * slope_after >= 0:
        return float(near[3])
    meeting = (level_after - level_before) / (slope_before - slope_after)
    return float(level_before + slope_before * np.clip(meeting, 0.0, 1.0))


def _block_starts(
    torque: FloatArray,
    turning_points: NDArray[np.intp],
    blocks: int,
    detail: FloatArray | None,
) -> NDArray[np.intp]:
    """Index of each block's first reading; a stretch's first block starts behind its reversal."""
    n = torque.size
    starts = [np.zeros(1, dtype=np.intp)]
    cuts = turning_points.copy()
    cuts[0] = -1
    # Around zero torque the teeth's stiffness bends within a few Nm: blocks are shorter there.
    narrow = _NARROW * float(np.max(np.abs(torque)))
    warped = torque + _DENSER * narrow * erf(torque / narrow)
    travel_total = np.abs(np.diff(warped[turning_points])).sum()
    for first, last in zip(cuts[:-1] + 1, cuts[1:], strict=True):
        stretch = warped[first : last + 1]
        span = stretch[-1] - stretch[0]
        rising = stretch if span >= 0 else -stretch
        travel = np.maximum.accumulate(rising) - rising[0]
        share = _TRAVEL_SHARE * travel / travel_total
        share += (1 - _TRAVEL_SHARE) * np.arange(stretch.size) / n
        if detail is not None:
            gathered = np.cumsum(detail[first : last + 1]) - detail[first]
            share = (1 - _DETAIL_SHARE) * share + _DETAIL_SHARE * gathered
        pieces = max(2, round(blocks * float(share[-1])))
        edges = np.searchsorted(share, np.linspace(0, share[-1], pieces, endpoint=False))
        starts.append(np.unique(edges) + first)
    return np.unique(np.concatenate(starts))


def fewest_blocks(turning_points: NDArray[np.intp]) -> int:
    """Blocks with which a model can be told from others, for a record that turns there.

    With a few blocks a stretch the bend inside them, known to second order, leads to other models.
    """
    return min(max(MAX_BLOCKS, _LEAST_A_STRETCH * (turning_points.size - 1)), MOST_BLOCKS)


def enough_blocks(torque: FloatArray, turning_points: NDArray[np.intp]) -> int:
    """Blocks that give the posterior of the readings, for a record that turns at these indices.

    The more readings or cycles, the narrower the posterior, beside which what blocks hide counts.

    Parameters
    ----------
    torque : (samples,) in Nm
    turning_points : indices of first reading, reversals and last reading
    """
    spans = np.abs(np.diff(torque[turning_points])).sum() / np.ptp(torque)
    of_readings = _LEAST_BLOCKS * min(max(1.0, torque.size / _READINGS_TO_THEM) ** (1 / 3), 2.0)
    of_stretches = min(_BLOCKS_A_STRETCH * (turning_points.size - 1), MOST_BLOCKS)
    # Blocks of one or two readings hide little, and as many as readings would spare nothing.
    of_spans = min(_BLOCKS_A_SPAN * float(spans), torque.size / 2, _MOST_OF_CYCLES)
    return round(float(max(of_readings, of_stretches, of_spans)))


def reduce_loop(
    loop: Loop,
    turning_points: NDArray[np.intp],
    torque_noise: float,
    kept: NDArray[np.bool_] | None = None,
    max_blocks: int = MAX_BLOCKS,
    whole: Course | None = None,
    detail: FloatArray | None = None,
) -> ReducedLoop:
    """Reduce a record to at most about `max_blocks` blocks; a short one keeps every reading.

    Parameters
    ----------
    loop : the record
    turning_points : indices of first reading, reversals and last reading
    torque_noise : standard deviation of a torque reading in Nm, to denoise the reversals
    kept : (samples,) False for readings to set aside as outliers
    max_blocks : aim for the number of blocks
    whole : course over all readings, where it is known already
    detail : (samples,) share of most of the blocks that each reading is to have, 1 in sum; evenly
        in torque and readings if None
    """
    whole = whole_course(loop, turning_points, torque_noise) if whole is None else whole
    torque, angle = loop.torque, loop.angle
    n = torque.size
    kept = np.ones(n, dtype=bool) if kept is None else kept
    if n <= max_blocks:
        starts = np.arange(n)
    else:
        starts = _block_starts(torque, turning_points, max_blocks, detail)
    block_of = np.repeat(np.arange(starts.size), np.diff(np.append(starts, n)))
    count = np.bincount(block_of, weights=kept.astype(float), minlength=starts.size)
    full = count > 0
    # A block whose readings were all set aside goes; block numbers close up behind it.
    renumber = np.where(full, np.cumsum(full) - 1, -1)
    stretch_of_start = np.searchsorted(turning_points[1:-1], starts, side="left")
    block_of = np.where(kept, renumber[block_of], -1)
    used = block_of >= 0
    blocks = int(full.sum())

    def mean(values: FloatArray) -> FloatArray:
        return np.bincount(block_of[used], weights=values[used], minlength=blocks) / count[full]

    mean_torque = mean(torque)
    deviation = torque - mean_torque[np.maximum(block_of, 0)]
    variance = mean(deviation**2)
    # Noise of the torque readings is not travel inside the block.
    variance = np.maximum(variance - torque_noise**2, 0.0) if n > max_blocks else variance * 0
    stretches = stretch_of_start[full]
    numbers = np.arange(turning_points.size - 1)
    path = TorquePath(
        torque=mean_torque,
        starts=np.searchsorted(stretches, numbers, side="left"),
        rising=whole.path.rising,
        variance=variance if n > max_blocks else None,
        reversal_torque=whole.path.reversal_torque,
    )
    return ReducedLoop(
        course=replace(
            whole,
            path=path,
            order=mean(whole.order),
            time=None if whole.time is None else mean(whole.time),
            rate=None if whole.rate is None else mean(whole.rate),
            temperature=None if whole.temperature is None else mean(whole.temperature),
            output_angle=None if whole.output_angle is None else mean(whole.output_angle),
            output_speed=None if whole.output_speed is None else mean(whole.output_speed),
        ),
        angle=mean(angle),
        count=np.asarray(count[full], dtype=np.float64),
        position=mean(np.arange(n, dtype=np.float64)),
        block_of=block_of,
    )


def whole_course(loop: Loop, turning_points: NDArray[np.intp], torque_noise: float) -> Course:
    """Course over all readings of a record, its reversals' torque denoised."""
    path = TorquePath(
        loop.torque,
        np.concatenate([[0], turning_points[1:-1] + 1]),
        np.diff(loop.torque[turning_points]) > 0,
        reversal_torque=_reversal_torques(loop.torque, turning_points, torque_noise),
    )
    return record_course(loop, path, torque_noise)
