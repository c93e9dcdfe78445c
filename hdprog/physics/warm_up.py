"""Warm-up of a first-order system, and what a recorded temperature does beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hdprog.physics.parameters import FloatArray

_TELLING = 0.5  # °C: a temperature that moves less says nothing about a drift
_CONSTANTS = np.geomspace(0.02, 8.0, 96)
_LEAST_RISE = 0.5  # of the temperature's range: less is no warm-up, and divides by next to nothing
_ENOUGH = 2000  # readings of so slow a channel


def warm_up(clock: FloatArray, constant: FloatArray) -> FloatArray:
    """Curve (1 − exp(−t/τ))/(1 − exp(−1/τ)), (draws, samples), from 0 to 1 over a record.

    Parameters
    ----------
    clock : (samples,) t, time in parts of the record
    constant : (draws, 1) τ in parts of the record
    """
    return np.asarray(np.expm1(-clock / constant) / np.expm1(-1 / constant))


@dataclass(frozen=True)
class WarmUp:
    """The warm-up that is nearest to a recorded temperature.

    Attributes
    ----------
    level, rise : °C at the record's start, and how much is added by its end
    constant : τ in parts of the record
    """

    level: float
    rise: float
    constant: float

    @staticmethod
    def nearest(clock: FloatArray, temperature: FloatArray) -> WarmUp | None:
        """By least squares, of a temperature (samples,) in °C; None where that hardly moves."""
        moved = float(np.ptp(temperature))
        if moved <= _TELLING:
            return None
        thinned = slice(None, None, -(-clock.size // _ENOUGH))
        seen = temperature[thinned] - temperature[thinned].mean()
        curves = warm_up(clock[thinned], _CONSTANTS[:, None])
        curves -= curves.mean(axis=1, keepdims=True)
        size, along = np.sum(curves**2, axis=1), curves @ seen
        best = int(np.argmax(along**2 / size))
        rise = float(along[best] / size[best])
        rise = float(np.copysign(max(abs(rise), _LEAST_RISE * moved), rise))
        constant = float(_CONSTANTS[best])
        level = float(np.mean(temperature - rise * warm_up(clock, np.array([[constant]]))[0]))
        return WarmUp(level, rise, constant)

    def beside(self, clock: FloatArray, temperature: FloatArray) -> FloatArray:
        """What a temperature (samples,) in °C does beside the warm-up, over its rise."""
        curve = warm_up(clock, np.array([[self.constant]]))[0]
        return np.asarray((temperature - self.level) / self.rise - curve)
