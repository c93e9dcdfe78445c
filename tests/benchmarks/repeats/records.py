"""Measured records as groups of repeats: single whole cycles, or records of one state.

A cycle runs from one extreme of positive torque to the next, so that the drive model, which
forgets at an extreme what went before, sees the same programme each time. What lies before the
first and behind the last extreme is left out. The springs' records hold one cycle each, from rest;
their first seconds are left out, as the records' description asks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

import hdprog
from hdprog.data.column_options import parse_columns, parse_select
from hdprog.data.loop import Loop
from hdprog.data.noise_level import channel_noise
from hdprog.data.turning_points import turning_points
from hdprog.physics.figures import ARCMIN_PER_RAD, LOST_MOTION_SHARE
from hdprog.physics.parameters import FloatArray

LARGE, SMALL, SPRING = "large cycles", "small cycles", "spring"
KINDS = (LARGE, SMALL, SPRING)

_SPRING = ("torsion-spring", "torque=torque_out:Nm,angle=displacement:deg,time=time:s")
_RAMPS = ("cycloidal-torque-ramps", "torque=TORQUE:Nm,angle=POSITION:rev,time=TIME:s")
_SELECT = {LARGE: "test_nr=100,101,102", SMALL: "test_nr=0,1,2,3,4"}
_STATES = (
    "base_init1",
    "base_runin1",
    "conic_init1",
    "conic_runin1",
    "conic_1pre1",
    "conic_3pre1",
    "conic_5pre1",
)
_PAIRS = {"4 Nm": ("kt-4-7", "kt-4-8"), "6 Nm": ("kt-6-1", "kt-6-2"), "8 Nm": ("kt-8-1", "kt-8-2")}
_REST = 4.0  # s at the beginning of the springs' records
_LEVELS = 33  # torques that the gap between the branches is averaged over


@dataclass(frozen=True)
class Group:
    """Repeats of one state.

    Attributes
    ----------
    name, kind : of the state
    loops : the repeats
    torque : that all can be compared at, in Nm: the smallest of their amplitudes
    """

    name: str
    kind: str
    loops: tuple[Loop, ...]
    torque: float


def kind_of(name: str) -> str:
    """Kind of the group with that name."""
    return name.split(": ")[0]


def groups(data: Path) -> Iterator[Group]:
    """All groups, the kinds after each other."""
    folder, columns = _RAMPS
    for kind in (LARGE, SMALL):
        for stem in _STATES:
            record = _read(data / folder, stem, columns, _SELECT[kind])
            yield _group(kind, stem, whole_cycles(record))
    folder, columns = _SPRING
    for state, stems in _PAIRS.items():
        loops = [_read(data / folder, stem, columns, None) for stem in stems]
        yield _group(SPRING, state, [_from(loop, _REST) for loop in loops])


def whole_cycles(record: Loop) -> list[Loop]:
    """Cut a record into its cycles from one extreme of positive torque to the next."""
    points = turning_points(record.torque)
    tops = [int(at) for at in points[1:-1] if record.torque[at] > 0]
    return [_part(record, slice(start, end + 1)) for start, end in pairwise(tops)]


def direct_figures(loop: Loop, torque: float) -> dict[str, float]:
    """Width, loss and lost motion read off a cycle's branches, no model in between.

    Straight lines through the readings near a torque give a branch's angle there, so that the
    noise of torque does not make a width of its own. Loss and lost motion need both branches over
    the whole range, which the springs' last rise, from −T to 0, does not have.
    """
    points = turning_points(loop.torque)
    falls = [
        slice(start, end + 1)
        for start, end in pairwise(points.tolist())
        if loop.torque[start] > 0 and loop.torque[end] < 0
    ]
    if not falls:
        return {}
    fall, rise = falls[0], slice(falls[0].stop - 1, int(points[-1]) + 1)
    whole = float(loop.torque[rise].max()) > 0.9 * torque
    if not whole:
        # Just below zero, as far as the last rise comes.
        at = -0.03 * torque
        gap = _angle_at(loop, fall, at, torque) - _angle_at(loop, rise, at, torque)
        return {"hysteresis_width_arcmin": ARCMIN_PER_RAD * gap}
    levels = torque * np.linspace(-0.95, 0.95, _LEVELS)
    gaps = [_angle_at(loop, fall, t, torque) - _angle_at(loop, rise, t, torque) for t in levels]
    # The branches meet at the extremes.
    every = np.concatenate([[-torque], levels, [torque]])
    area = float(np.trapezoid(np.concatenate([[0.0], gaps, [0.0]]), every))
    near = LOST_MOTION_SHARE * torque
    middle = [
        0.5 * (_angle_at(loop, fall, t, torque) + _angle_at(loop, rise, t, torque))
        for t in (-near, near)
    ]
    gap = _angle_at(loop, fall, 0.0, torque) - _angle_at(loop, rise, 0.0, torque)
    return {
        "hysteresis_width_arcmin": ARCMIN_PER_RAD * gap,
        "hysteresis_loss_J": area,
        "lost_motion_arcmin": ARCMIN_PER_RAD * (middle[1] - middle[0]),
    }


def _angle_at(loop: Loop, branch: slice, level: float, torque: float) -> float:
    """Angle of a branch in rad where its torque passes a level.

    Of a line of angle over order and one of torque over order, so that torque's noise, which
    would flatten a line of angle over torque, is averaged out.
    """
    order = np.arange(loop.torque[branch].size, dtype=float)
    smooth = _smoothed(loop.torque[branch], channel_noise(loop.torque), torque)
    near = np.abs(smooth - level) < 0.03 * torque
    if near.sum() < 5:
        near = np.abs(smooth - level) <= np.sort(np.abs(smooth - level))[4]
    x = order[near] - order[near].mean()
    t_line = np.polyfit(x, loop.torque[branch][near], 1)
    a_line = np.polyfit(x, loop.angle[branch][near], 1)
    return float(np.polyval(a_line, (level - t_line[1]) / t_line[0]))


def _smoothed(torque: FloatArray, noise: float, largest: float) -> FloatArray:
    """Torque averaged over as many readings as bring its noise to a hundredth of the largest."""
    half = int(np.clip((noise / (0.01 * largest)) ** 2 / 2, 0, torque.size // 20))
    padded = np.pad(torque, half, mode="edge")
    return np.convolve(padded, np.full(2 * half + 1, 1 / (2 * half + 1)), mode="valid")


def _group(kind: str, state: str, loops: list[Loop]) -> Group:
    amplitudes = [float(np.quantile(np.abs(loop.torque), 0.995)) for loop in loops]
    return Group(f"{kind}: {state}", kind, tuple(loops), float(f"{min(amplitudes):.3g}"))


def _read(folder: Path, stem: str, columns: str, select: str | None) -> Loop:
    paths = sorted(folder.glob(f"{stem}*.csv.gz"))
    if not paths:
        raise SystemExit(f"{folder}: no file {stem}*.csv.gz in the folder given by --data")
    chosen = None if select is None else parse_select(select)
    return hdprog.read_loop(paths[0], columns=parse_columns(columns), select=chosen)


def _from(loop: Loop, start: float) -> Loop:
    assert loop.time is not None
    return _part(loop, slice(int(np.searchsorted(loop.time, start)), len(loop)))


def _part(loop: Loop, part: slice) -> Loop:
    return Loop(
        torque=loop.torque[part],
        angle=loop.angle[part],
        time=None if loop.time is None else loop.time[part],
        source=loop.source,
    )
