"""What temperature does to a drive whose tests differ in it, in words."""

from __future__ import annotations

from collections.abc import Sequence

from hdprog.reporting.rounding import grouped, interval, significant
from hdprog.reporting.words import PROVISIONAL_NUMBERS, agree, counted, listed, quantity
from hdprog.results import TemperatureEffect, TrendSummary


def as_if_at(reference_C: float | None) -> str:
    """Say of a test by itself at what temperature it is told, where that is not its own."""
    return "" if reference_C is None else f" as it would be at {_degrees(reference_C)}"


def temperature_words(trend: TrendSummary, keys: Sequence[str]) -> str:
    """What 10 K change in some figures, by their keys; empty where tests do not differ in it."""
    found = trend.temperature
    if found is None:
        return ""
    doubt = "" if trend.converged else f"{PROVISIONAL_NUMBERS} "
    at = _degrees(found.reference_C)
    text = f"{doubt}Trend and forecast are told at {at}, the mean of the tests"
    if found.unknown:
        taken = agree(found.unknown, "is", "are")
        text += (
            f"; {counted(found.unknown, 'test')} without a temperature {taken} taken at it, give "
            f"or take {significant(found.spread_K, 2)} K"
        )
    moved = [_moved(key, found) for key in dict.fromkeys(keys) if key in found.percent_per_10K]
    return f"{text}. What 10 K more change: {listed(moved)}." if moved else f"{text}."


def _moved(key: str, found: TemperatureEffect) -> str:
    levels = found.percent_per_10K[key]
    low, middle, high = interval(levels[0.05], levels[0.50], levels[0.95])
    return f"{quantity(key).name} by {middle} % (90 %: {low} to {high} %)"


def _degrees(temperature_C: float) -> str:
    return f"{grouped(temperature_C, 0)} °C"
