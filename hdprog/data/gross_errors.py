"""Readings that are wrong beyond any doubt, levelled before a model is fitted.

A least-squares fit survives an error of some noise standard deviations and is wrecked by one of
some hundred; a wrong torque also turns the loop where the drive did not. What is left in doubt is
for the residual of a fit to settle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from hdprog.data.loop import Loop
from hdprog.data.noise_level import noise_sd

__all__ = ["levelled"]

_CERTAIN = 8.0  # noise standard deviations
_STEPS = 3.0  # usual moves from sample to sample: a sharp reversal stands out by one
_USUAL = 13  # samples over which moves are usual
_LONGEST = 2  # readings in a row
_MOST = 0.1  # share of readings from which on they are no errors but the record's own way
_ROUNDING = 1e-9  # of a channel's span


def levelled(loop: Loop) -> tuple[Loop, NDArray[np.bool_]]:
    """Replace isolated readings of torque or angle that are wrong beyond any doubt.

    Parameters
    ----------
    loop : the record

    Returns
    -------
    the record with straight lines drawn through wrong readings, and which readings those were,
    (samples,)
    """
    torque, wrong_torque = _straightened(loop.torque, loop.time)
    angle, wrong_angle = _straightened(loop.angle, loop.time)
    wrong = wrong_torque | wrong_angle
    return (replace(loop, torque=torque, angle=angle) if wrong.any() else loop), wrong


def _straightened(
    values: NDArray[np.float64], time: NDArray[np.float64] | None
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """A channel (samples,) without readings that jump away and back, and which those were."""
    none = np.zeros(values.size, dtype=bool)
    if values.size < _USUAL:
        return values, none
    certain = _CERTAIN * noise_sd(values, time) + _ROUNDING * float(np.ptp(values))
    usual = median_filter(np.abs(np.diff(values, prepend=values[0])), size=_USUAL)
    wrong = none.copy()
    for apart in range(1, _LONGEST + 1):
        jumps = values[apart:] - values[:-apart]
        # At the record's ends there is a neighbour on one side only.
        into = np.concatenate([-jumps[:apart], jumps])
        back = np.concatenate([-jumps, jumps[-apart:]])
        height = np.where(into * back > 0, np.minimum(np.abs(into), np.abs(back)), 0.0)
        wrong |= height > certain + _STEPS * apart * usual
    if not wrong.any() or wrong.mean() > _MOST:
        return values, none
    index = np.arange(values.size, dtype=np.float64)
    straight = values.copy()
    straight[wrong] = np.interp(index[wrong], index[~wrong], values[~wrong])
    return straight, wrong
