"""A wearing CSF-25-80 as the simulator knows it: parameters along a path of wear.

Wear 0 is the new drive and wear 1 the drive after 100 h at rated load of Table 2; between and
beyond, each parameter moves on a course of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hdprog.physics.parameters import FloatArray, Parameters

_K_F, _A = 78_197.8, 1833.5
_B_NEW, _B_FLOOR, _B_WORN = 1 / (1 / 50_923.2 - 1 / _K_F), 4_000.0, 5_729.6


def worn_parameters(wear: FloatArray) -> Parameters:
    """Parameters of a drive at a given wear.

    Parameters
    ----------
    wear : (points,) 0 new, 1 as worn as after the published test, beyond 1 worse

    Returns
    -------
    each parameter (points,), SI units
    """
    decay = np.log((_B_NEW - _B_FLOOR) / (_B_WORN - _B_FLOOR))
    return {
        "K_F": np.full_like(wear, _K_F),
        "K_W": 101_837.5 - 3_288.8 * wear,
        "a": np.full_like(wear, _A),
        "b": _B_FLOOR + (_B_NEW - _B_FLOOR) * np.exp(-decay * wear),
        "T_T": 30.0 * wear,
        "c": -1.177 + 0.025 * wear,
        "T_i": 115.5 * (70.2 / 115.5) ** wear,
        "mu": 0.066 * (0.076 / 0.066) ** np.minimum(wear, 1000.0),  # no overflow far past all use
    }


@dataclass(frozen=True)
class WearScenario:
    """How fast a drive wears.

    Attributes
    ----------
    rate : wear after 1 000 h
    exponent : of the power law of wear over hours
    volatility : relative standard deviation of the wear's increments over 1 000 h
    """

    rate: float
    exponent: float
    volatility: float

    def course(self, hours: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Wear at increasing hours (points,): a power law with random increments, never falling."""
        mean = self.rate * (hours / 1000.0) ** self.exponent
        steps = np.diff(mean, prepend=0.0)
        spread = self.volatility * np.sqrt(np.diff(hours, prepend=0.0) / 1000.0) * self.rate
        return np.cumsum(np.maximum(steps + spread * rng.standard_normal(hours.size), 0.0))


SCENARIOS: dict[str, WearScenario] = {
    "wearing": WearScenario(rate=0.65, exponent=1.0, volatility=0.03),
    "healthy": WearScenario(rate=0.02, exponent=0.6, volatility=0.01),
}
