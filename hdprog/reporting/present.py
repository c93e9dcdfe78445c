"""Present condition of a drive from one test: its figures, and where they stand to limits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise, takewhile
from typing import Literal

from hdprog.config import Limit
from hdprog.reporting.rounding import hours
from hdprog.reporting.words import (
    capital,
    figure_interval,
    listed,
    quantity,
    threshold_words,
    with_unit,
)
from hdprog.results import LEVELS, TestResult, since_replaced

_TOLD = ("secant_stiffness_Nm_per_rad", "hysteresis_width_arcmin", "lost_motion_arcmin")


def value_words(levels: Mapping[float, float], key: str) -> str:
    """Quantiles of a figure in words: "0.41 arcmin (90 %: 0.40 to 0.42)"."""
    low, middle, high = figure_interval(key, levels[0.05], levels[0.50], levels[0.95])
    return f"{with_unit(middle, quantity(key).unit)} (90 %: {low} to {high})"


def condition(test: TestResult, which: str) -> str:
    """Say the most telling figures of a test in one sentence."""
    chosen = [key for key in test.figures if key.partition("@")[0] in _TOLD]
    if not chosen:
        return "No figure of merit could be computed from this test."
    parts = [
        f"a {quantity(key).name} of {value_words(test.figures[key], key)}" for key in chosen[:4]
    ]
    return f"{which} shows {listed(parts)}."


def against_limit(test: TestResult, limit: Limit) -> str:
    """Where a test's figure stands to a limit, said by quantiles.

    Five quantiles bound the probability that the figure is past the limit; they do not give it.
    """
    levels = test.figures.get(limit.key)
    named = quantity(limit.key)
    bound = threshold_words(limit.key, limit.threshold)
    if levels is None:
        return f"{capital(named.name)} is not among this test's figures; its limit is {bound}."
    said = f"{capital(named.name)} is {value_words(levels, limit.key)}"
    where = standing(levels, limit)
    if where == "past":
        return f"{said}: past its limit, {limit.direction} {bound}, with a probability above 95 %."
    if where == "inside":
        safe = f"not {limit.direction} {bound}"
        return f"{said}: inside its limit, {safe}, with a probability above 95 %."
    at_least, at_most = probability_bounds(levels, limit)
    return (
        f"{said}: its limit of {bound} lies in that spread; the probability that it is past it "
        f"is between {100 * at_least:.0f} and {100 * at_most:.0f} %."
    )


def gravest_first(test: TestResult, limits: Sequence[Limit]) -> list[Limit]:
    """Limits in the order of what a test says of them: past, about, not told, inside."""

    def gravity(limit: Limit) -> int:
        levels = test.figures.get(limit.key)
        return (
            2 if levels is None else {"past": 0, "about": 1, "inside": 3}[standing(levels, limit)]
        )

    return sorted(limits, key=gravity)


def is_past(test: TestResult, limit: Limit) -> bool:
    """Whether a test's figure is past a limit with a probability above 95 %."""
    levels = test.figures.get(limit.key)
    return levels is not None and standing(levels, limit) == "past"


def past_by_itself(tests: Sequence[TestResult], limits: Iterable[Limit]) -> list[str]:
    """Say which tests of the drive were past a limit that all tests together are not past."""
    said = []
    for limit in limits:
        past = [test for test in since_replaced(tests) if is_past(test, limit)]
        if past:
            last, named = past[-1], quantity(limit.key)
            said.append(
                f"Test {last.test_id} by itself is past the limit on {named.name}, "
                f"{limit.direction} {threshold_words(limit.key, limit.threshold)}, with "
                f"{value_words(last.figures[limit.key], limit.key)}; the forecast is that of all "
                "tests together."
            )
    return said


def passed_at_an_event(tests: Sequence[TestResult], limit: Limit) -> str:
    """What the test before said, where a figure passed its limit as something was done; or ""."""
    for before, after in reversed(list(pairwise(since_replaced(tests)))):
        levels = before.figures.get(limit.key)
        if after.event and levels and standing(levels, limit) == "inside" and is_past(after, limit):
            return (
                f" Test {before.test_id}, before the drive was {after.event}, had "
                f"{value_words(levels, limit.key)}: what was done may have taken it past, not wear."
            )
    return ""


def past_since(tests: Sequence[TestResult], limit: Limit) -> str:
    """From which test on each has shown a limit passed, if not by the last alone; or ""."""
    newest_first = reversed(since_replaced(tests))
    shown = list(takewhile(lambda test: is_past(test, limit), newest_first))
    if len(shown) < 2:
        return ""
    first = shown[-1]
    at = "" if first.service_hours is None else f" at {hours(first.service_hours)}"
    return f" Every test since {first.test_id}{at} shows it passed."


def standing(levels: Mapping[float, float], limit: Limit) -> Literal["past", "inside", "about"]:
    """Where a figure stands to a limit by its quantiles: past it or inside at 95 %, or about it."""
    at_least, at_most = probability_bounds(levels, limit)
    if at_least > 0.949:
        return "past"
    return "inside" if at_most < 0.051 else "about"


def probability_bounds(levels: Mapping[float, float], limit: Limit) -> tuple[float, float]:
    """Smallest and largest probability that the figure is past a limit, given its quantiles."""
    above = limit.direction == "above"
    under = [level for level in LEVELS if levels[level] <= limit.threshold]
    over = [level for level in LEVELS if levels[level] > limit.threshold]
    # P(figure <= threshold) lies between the largest level under it and the smallest over it.
    low, high = max(under, default=0.0), min(over, default=1.0)
    return (1.0 - high, 1.0 - low) if above else (low, high)
