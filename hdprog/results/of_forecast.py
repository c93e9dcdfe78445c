"""When limits are first crossed, as things are and under other loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hdprog.config import Limit
from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class Forecast:
    """First crossing of one limit; `limit` is None for the first of all limits.

    Attributes
    ----------
    now_hours : service hours of the last test
    already_crossed : the state at now is past the limit with more than even odds
    inspect_before_hours : service hours at which P(crossed) reaches the acceptable risk, or None
        past the horizon
    remaining_hours : level → hours from now, None past the horizon
    crossing_probability : (times, 2) service hours and P(crossed), non-decreasing, now to horizon
    probability_held_up_by_end_of_wear : by how much P(crossed) by the horizon would be larger if
        wear came to no end
    """

    limit: Limit | None
    now_hours: float
    already_crossed: bool
    acceptable_risk: float
    horizon_hours: float
    inspect_before_hours: float | None
    probability_crossed_by_shutdown: float | None
    probability_crossed_by_horizon: float
    remaining_hours: Mapping[float, float | None]
    crossing_probability: FloatArray
    probability_held_up_by_end_of_wear: float = 0.0


@dataclass(frozen=True)
class LoadScenario:
    """What the forecasts would be under another load from now on.

    Attributes
    ----------
    load : torque to come over the torque so far
    forecasts : of the same limits, from the same draws of the trend
    """

    load: float
    forecasts: tuple[Forecast, ...]
