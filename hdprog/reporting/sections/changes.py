"""What changed since the test before: each figure then and now, and whether it is clear."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hdprog.explanation import DriveExplanation, Explanation
from hdprog.reporting.bias import deviation
from hdprog.reporting.effect_words import effect_name
from hdprog.reporting.rounding import grouped, hours, rounded
from hdprog.reporting.sections.table import Row, Table, Value
from hdprog.reporting.words import capital, listed, quantity
from hdprog.results import LEVELS, DriveResult, TestResult, TrendSummary

_CLEAR = 2.0  # standard deviations of the difference from which a change is said to be clear
_TENTH = 0.2  # the uncertainty with which a number is rounded to a tenth
_NONE = "–"
_UNMOVED = "none of the figures that matter here has moved"


@dataclass(frozen=True)
class Changes:
    """The last two tests side by side: what to know in words, and every figure in a table."""

    text: str
    table: Table


def changes(result: DriveResult) -> Changes | None:
    """Compare the last test with the one before it; None for a single test."""
    if len(result.tests) < 2:
        return None
    followed = () if result.trend is None else result.trend.followed
    before, now = (_as_followed(test) if followed else test for test in result.tests[-2:])
    limited = [limit.key for limit in result.drive.limits]
    keys = sorted(
        (key for key in now.figures if key in before.figures), key=lambda key: key not in limited
    )
    rows = [_row(key, before, now) for key in keys]
    warm = result.trend is not None and result.trend.temperature is not None
    beside = "mounting the drive anew" + (" or its temperature" if warm else "")
    counted = ""
    if followed:
        names = listed(effect_name(effect) for effect in followed)
        counted = f" Width, loss and lost motion count {names} in, as the trend does."
    table = Table.flat(
        "Figures of merit of the last two tests: median, below it the 90 % interval."
        f"{counted} A change is "
        f"called clear from {_CLEAR:g} standard deviations of the difference of the two tests; how "
        f"far {beside} moves a figure is not in these, but in the trend.",
        ("figure", _head(before), _head(now), "change", "said by the two tests"),
        rows,
        doubtful=not (before.converged and now.converged),
    )
    told = [key for key in keys if key in limited] or keys
    said = (
        _text(told, before, now),
        _of_effects(before, now, result.explanation),
        _against_trend(told, before, now, result.trend),
    )
    return Changes("".join(said), table)


def _as_followed(test: TestResult) -> TestResult:
    """The test with the lasting effects in its figures, where wear has brought them."""
    return replace(test, figures={**test.figures, **test.figures_with_effects})


def _head(test: TestResult) -> str:
    when = "" if test.service_hours is None else f", {hours(test.service_hours)}"
    return f"{test.test_id}{when}"


def _row(key: str, before: TestResult, now: TestResult) -> Row:
    old, new, named = before.figures[key], now.figures[key], quantity(key)
    change, spread = new[0.50] - old[0.50], _spread(old, new)
    shift = _shift(old, new)
    difference = rounded(named.factor * change, named.factor * spread)
    share = "" if old[0.50] == 0 else f"{_signed(_percent(change, spread, old[0.50]))} %"
    cells = (
        Value.of(old, named.factor),
        Value.of(new, named.factor),
        Value(_signed(difference), share),
        _words(shift),
    )
    return Row(capital(named.head), cells)


def _percent(change: float, spread: float, old: float) -> str:
    """Per cent of the old value to the digits that the spread allows, a tenth at most."""
    return rounded(100.0 * change / old, max(100.0 * spread / abs(old), _TENTH))


def _spread(old: Mapping[float, float], new: Mapping[float, float]) -> float:
    """Standard deviation of the difference of two independent tests."""
    return math.hypot(deviation(old), deviation(new))


def _shift(old: Mapping[float, float], new: Mapping[float, float]) -> float | None:
    spread = _spread(old, new)
    return (new[0.50] - old[0.50]) / spread if spread > 0 else None


def _clear_shift(key: str, before: TestResult, now: TestResult) -> float:
    """A figure's shift in standard deviations where it is called clear, else 0."""
    shift = _shift(before.figures[key], now.figures[key])
    return 0.0 if shift is None or abs(shift) < _CLEAR else shift


def _signed(number: str) -> str:
    return number if number[:1] in "−–" or not number.strip("0.") else f"+{number}"


def _words(shift: float | None) -> str:
    if shift is None:
        return _NONE
    if abs(shift) < _CLEAR:
        return "no clear change"
    return f"{'risen' if shift > 0 else 'fallen'} ({grouped(abs(shift), 1)} standard deviations)"


def _against_trend(
    keys: list[str], before: TestResult, now: TestResult, trend: TrendSummary | None
) -> str:
    """Figures that moved against the trend over all tests, in words; empty without any."""
    found = []
    for key in keys:
        along = None if trend is None else trend.figures.get(key)
        if along is None:
            continue
        ends = np.interp(_hours_of(before, now), along.hours, along.quantiles[LEVELS.index(0.50)])
        if (ends[1] - ends[0]) * _clear_shift(key, before, now) < 0:
            found.append(quantity(key).name)
    if not found:
        return ""
    return (
        f" The trend over all tests goes the other way in {listed(found)}: what differs between "
        "tests beside wear, such as mounting the drive anew, moves a figure, too."
    )


def _hours_of(*tests: TestResult) -> list[float]:
    return [0.0 if test.service_hours is None else test.service_hours for test in tests]


def _text(keys: list[str], before: TestResult, now: TestResult) -> str:
    moved: dict[str, list[str]] = {"risen": [], "fallen": []}
    for key in keys:
        shift = _clear_shift(key, before, now)
        if shift != 0:
            moved["risen" if shift > 0 else "fallen"].append(quantity(key).name)
    parts = [
        f"{listed(names)} {'has' if len(names) == 1 else 'have'} {way}"
        for way, names in moved.items()
        if names
    ]
    since = f"Since test {before.test_id}"
    if before.service_hours is not None and now.service_hours is not None:
        since += f", {hours(now.service_hours - before.service_hours)} earlier"
    if now.event:
        since += f" and before the drive was {now.event}"
    said = "; ".join(parts) if parts else f"{_UNMOVED} by more than the two tests' noise"
    return f"{since}: {said}."


def _of_effects(
    before: TestResult, now: TestResult, explanation: Explanation | DriveExplanation | None
) -> str:
    """Effects that one of the tests has alone; what a test cannot show is not said to be absent."""
    text = ""
    for only, other, lead in (
        (now, before, "Effects that the test before did not have"),
        (before, now, "Effects that only the test before had"),
    ):
        hidden: tuple[str, ...] = ()
        if isinstance(explanation, DriveExplanation):
            hidden = explanation.not_shown_by(other.test_id)
        differ = [effect for effect in only.effects if effect not in other.effects]
        seen = [effect_name(effect) for effect in differ if effect not in hidden]
        unseen = [effect_name(effect) for effect in differ if effect in hidden]
        if seen:
            text += f" {lead}: {listed(seen)}."
        if unseen:
            text += f" Test {other.test_id} cannot show {listed(unseen, 'or')}, which test "
            text += f"{only.test_id} has."
    return text
