"""Where wear ends in a forecast is an assumption: how much rests on it, in words."""

from __future__ import annotations

from hdprog.reporting import outlook
from hdprog.reporting.rounding import hours, percent, percent_beside
from hdprog.reporting.words import listed, quantity
from hdprog.results import DriveResult, Forecast

_COUNTS = 0.05  # of probability that a limit would be passed but for the end of wear


def end_of_wear(result: DriveResult) -> str:
    """Say how much surer the limits would be passed if wear came to no end; "" if hardly."""
    told = [
        f"{quantity(one.limit.key).name} {percent(_without_end(one))} instead of "
        f"{percent(one.probability_crossed_by_horizon)}"
        for one in result.forecasts
        if one.limit is not None and _counts(one)
    ]
    if not told:
        return ""
    by = hours(result.forecasts[0].horizon_hours)
    return (
        "Where wear comes to an end is an assumption that no test of this drive bears out. If it "
        f"comes to none, the risk by {by} is for {listed(told)}."
    )


def kept_by_the_end(result: DriveResult) -> list[str]:
    """Sentence where it is the end of wear that keeps the accepted risk; else none."""
    main = outlook.overall(result.forecasts)
    if main is None or not _counts(main) or main.inspect_before_hours is not None:
        return []
    risk = percent_beside(_without_end(main), main.acceptable_risk)
    return [
        "That rests on where wear is assumed to come to an end: if it comes to none, the risk by "
        f"{hours(main.horizon_hours)} is {risk}."
    ]


def _counts(forecast: Forecast) -> bool:
    return forecast.probability_held_up_by_end_of_wear >= _COUNTS


def _without_end(forecast: Forecast) -> float:
    held_up = forecast.probability_held_up_by_end_of_wear
    return min(forecast.probability_crossed_by_horizon + held_up, 1.0)
