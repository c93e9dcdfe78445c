"""The last reading before each reversal, where the extreme one is not.

What depends on the direction of torque jumps there. Of a noisy hold the highest reading is any, and
those behind it do not unload; of a sharp corner the highest may lie behind the reversal already.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["last_before_reversal"]

_SHALLOW, _DEEP = 4.0, 16.0  # noise deviations off the extreme
_LEAST_NOISE = 1e-5  # of the span: a record without noise has rounding
# A hold's sides are steep: it is hardly wider deep down. Of a rounded peak (a parabola) widths at
# four times the depth are twice as large, of a corner four times.
_WIDER = 1.5
_SHORTEST_HOLD = 2.5  # readings
_OF_A_LINE = 3  # readings


def last_before_reversal(
    torque: NDArray[np.float64], extremes: NDArray[np.intp], noise: float
) -> NDArray[np.intp]:
    """Move extremes to the last reading before the torque turns.

    Parameters
    ----------
    torque : (n,) in Nm
    extremes : (k,) increasing indices, of peaks and valleys in turn
    noise : standard deviation of a torque reading in Nm

    Returns
    -------
    (k,) increasing indices
    """
    unit = max(noise, _LEAST_NOISE * float(np.ptp(torque)))
    edges = np.concatenate(([0], extremes, [torque.size - 1]))
    moved = extremes.copy()
    for number, at in enumerate(extremes.tolist()):
        before, after = int(edges[number]), int(edges[number + 2])
        sign = 1.0 if torque[at] > torque[before] else -1.0
        near = sign * torque[before : after + 1]
        end = _end_of_hold(near, at - before, unit)
        if end is None:
            end = at - before - _lies_behind(near, at - before, unit)
        moved[number] = before + end
    return moved


def _end_of_hold(near: NDArray[np.float64], at: int, unit: float) -> int | None:
    """Last reading of a hold about the peak at an index of readings (m,); None if it is no hold."""
    # The highest reading of many stands two deviations above their mean.
    run = near >= near[at] - (_SHALLOW + 2) * unit
    first = at - int(np.argmin(run[at::-1])) if not run[: at + 1].all() else 0
    last = at + int(np.argmin(run[at:])) if not run[at:].all() else near.size - 1
    level = float(np.median(near[first + 1 : last]))
    shallow = _sides(near, at, level - _SHALLOW * unit)
    deep = _sides(near, at, level - _DEEP * unit)
    if shallow is None or deep is None:
        return None
    width = shallow[1] - shallow[0]
    if width < _SHORTEST_HOLD or deep[1] - deep[0] > _WIDER * width:
        return None
    # Where the line of what follows meets the level; before it, where the torque leaves gently.
    meets = shallow[1] - (deep[1] - shallow[1]) * _SHALLOW / (_DEEP - _SHALLOW)
    held = np.flatnonzero(near[: int(np.ceil(shallow[1]))] >= level - 2 * unit)
    return max(at, min(int(np.floor(meets)), int(held[-1])))


def _sides(near: NDArray[np.float64], at: int, level: float) -> tuple[float, float] | None:
    """Where readings about a peak cross a level on either side, between readings."""
    below = near < level
    if not below[:at].any() or not below[at:].any():
        return None
    left = at - int(np.argmax(below[at::-1]))
    right = at + int(np.argmax(below[at:]))
    return (
        left + float((level - near[left]) / (near[left + 1] - near[left])),
        right - float((level - near[right]) / (near[right - 1] - near[right])),
    )


def _lies_behind(near: NDArray[np.float64], at: int, unit: float) -> bool:
    """Whether the highest reading of a sharp corner lies on the line of what follows."""
    if at < _OF_A_LINE or near.size - 1 - at < _OF_A_LINE:
        return False
    steps = np.arange(1.0, _OF_A_LINE + 1)
    rise, reached = np.polyfit(-steps[::-1], near[at - _OF_A_LINE : at], 1)
    fall, left = np.polyfit(steps, near[at + 1 : at + 1 + _OF_A_LINE], 1)
    sharp = rise > _SHALLOW * unit and -fall > _SHALLOW * unit
    return bool(sharp and reached - near[at] > 2 * unit + 2 * abs(left - near[at]))
