"""Readings that are wrong beyond any doubt, levelled before a model is fitted.

A least-squares fit survives an error of some noise standard deviations and is wrecked by one of
some hundred; a wrong torque also turns the loop where the drive did not. Where torque and angle
jump together, as they go together in the rest of the record, the drive was loaded: a short step of
dead weights does that. What is left in doubt is for the residual of a fit to settle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from hdprog.data.loop import Loop
from hdprog.data.noise_level import noise_sd, quantisation_step

__all__ = ["levelled"]

_CERTAIN = 8.0  # noise standard deviations
_STEPS = 3.0  # usual moves from sample to sample: a sharp reversal stands out by one
_USUAL = 13  # samples over which moves are usual
_LONGEST = 2  # readings in a row
_MOST = 0.1  # share of readings from which on they are no errors but the record's own way
_ROUNDING = 1e-9  # of a channel's span
_SEEN = 3.0  # noise standard deviations from which on a channel moved, too
_ALIKE = 2.0  # largest factor between a jump's ratio of the channels and the record's


def levelled(loop: Loop) -> tuple[Loop, NDArray[np.bool_]]:
    """Replace isolated readings that are wrong beyond any doubt.

    Temperature and output angle are drawn straight, too: a single wrong one would be the span that
    effects are scaled by.

    Parameters
    ----------
    loop : the record

    Returns
    -------
    the record with straight lines drawn through wrong readings, and which readings of torque or
    angle those were, (samples,)
    """
    noise = (
        _more_than_rounding(loop.torque_scatter, loop.torque),
        _more_than_rounding(loop.angle_scatter, loop.angle),
    )
    wrong_torque = _jumping(loop.torque, noise[0])
    wrong_angle = _jumping(loop.angle, noise[1])
    loaded = _loaded(loop, wrong_torque | wrong_angle, noise)
    torque, wrong_torque = _straightened(loop.torque, wrong_torque & ~loaded)
    angle, wrong_angle = _straightened(loop.angle, wrong_angle & ~loaded)
    wrong = wrong_torque | wrong_angle
    if wrong.any():
        loop = replace(loop, torque=torque, angle=angle)
    temperature, output_angle = (
        _sound(values, loop.time) for values in (loop.temperature, loop.output_angle)
    )
    if temperature is not loop.temperature or output_angle is not loop.output_angle:
        loop = replace(loop, temperature=temperature, output_angle=output_angle)
    return loop, wrong


def _sound(
    values: NDArray[np.float64] | None, time: NDArray[np.float64] | None
) -> NDArray[np.float64] | None:
    """A channel beside torque and angle, with lines through its wrong readings; else itself."""
    if values is None:
        return None
    noise = _more_than_rounding(noise_sd(values, time), values)
    straight, _ = _straightened(values, _jumping(values, noise))
    return straight


def _more_than_rounding(noise: float, values: NDArray[np.float64]) -> float:
    """Noise of a channel, with no less than what rounding leaves."""
    return noise + _ROUNDING * float(np.ptp(values))


def _jumping(values: NDArray[np.float64], noise: float) -> NDArray[np.bool_]:
    """Which readings of a channel (samples,) jump away and back."""
    wrong = np.zeros(values.size, dtype=bool)
    if values.size < _USUAL:
        return wrong
    usual = median_filter(np.abs(np.diff(values, prepend=values[0])), size=_USUAL)
    for apart in range(1, _LONGEST + 1):
        jumps = values[apart:] - values[:-apart]
        # At the record's ends there is a neighbour on one side only.
        into = np.concatenate([-jumps[:apart], jumps])
        back = np.concatenate([-jumps, jumps[-apart:]])
        height = np.where(into * back > 0, np.minimum(np.abs(into), np.abs(back)), 0.0)
        wrong |= height > _CERTAIN * noise + _STEPS * apart * usual
    return wrong


def _loaded(loop: Loop, jumping: NDArray[np.bool_], noise: tuple[float, ...]) -> NDArray[np.bool_]:
    """Which jumping readings (samples,) torque and angle share, in the ratio of the record."""
    if not jumping.any() or jumping.all():
        return np.zeros(jumping.size, dtype=bool)
    index = np.arange(jumping.size, dtype=np.float64)
    away = []
    for values, own in zip((loop.torque, loop.angle), noise, strict=True):
        rest = values[~jumping]
        moved = values - np.interp(index, index[~jumping], rest)
        # In shares of the channel's span both move alike; what is not above the noise did not move.
        moved[np.abs(moved) <= _SEEN * own] = 0.0
        away.append(moved / (float(np.ptp(rest)) or np.inf))
    torque, angle = away
    alike = (np.abs(angle) < _ALIKE * np.abs(torque)) & (np.abs(torque) < _ALIKE * np.abs(angle))
    return jumping & alike & (torque * angle > 0)


def _straightened(
    values: NDArray[np.float64], wrong: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """A channel (samples,) with lines through its wrong readings, and which those are.

    Where the channel has steps, they stay on its levels: by levels between them it would be taken
    for finer, and for less noisy, than it is.
    """
    if not wrong.any() or wrong.mean() > _MOST:
        return values, np.zeros(wrong.size, dtype=bool)
    index = np.arange(values.size, dtype=np.float64)
    straight = values.copy()
    kept = values[~wrong]
    straight[wrong] = np.interp(index[wrong], index[~wrong], kept)
    if quantisation_step(kept) is not None:
        levels = np.unique(kept)
        between = 0.5 * (levels[1:] + levels[:-1])
        straight[wrong] = levels[np.searchsorted(between, straight[wrong])]
    return straight, wrong
