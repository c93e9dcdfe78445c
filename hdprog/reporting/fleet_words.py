"""A drive in a list of many: one sentence, how bad it is, and where its leading figure went.

Everything is read off a summary (schema `hdprog.summary/1`), so that lists can be made of drives
that were run long ago.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hdprog.config import ReportSettings
from hdprog.config.limits import figure_key
from hdprog.reporting.reader_units import shown_in
from hdprog.reporting.words import FIRST_LIMIT, quantity, tidy

PROVISIONAL = "Not converged: this is provisional."
"""Beside the sentence of a drive that is: it travels without the label that says so."""

_RANKS = {"act": 0, "plan": 2, "present": 3, "good": 4}
_DUE, _PASSED = 1, 0
_SENTENCE_END = re.compile(r"(?<=[.!?]) (?=[A-Z])")
_NO_PACE = ("There is one test only", "All tests ")
_CAVEATS = ("Not converged", "The numbers below", *_NO_PACE)


@dataclass(frozen=True)
class Course:
    """The tests' medians of the figure whose limit leads, for a small picture.

    Attributes
    ----------
    name, unit : of the figure, in words
    points : service hours and value, in the order of the hours
    limit : the threshold, in the same unit
    """

    name: str
    unit: str
    points: tuple[tuple[float, float], ...]
    limit: float


@dataclass(frozen=True)
class FleetEntry:
    """What a list of drives shows of one.

    Attributes
    ----------
    status : as the verdict has it: act, plan, good or present
    provisional : something did not converge
    label : the status in a few words
    sentence : what to do or to expect, in one sentence; a second one where no test tells the pace
    rank : 0 is worst
    rank_hours : orders drives of one rank, lowest first
    remaining_hours : q05, q50 and q95 to the first limit; None past the horizon; empty without
    inspect_before_hours : service hours, None where there is no need before the horizon
    course : of the leading figure, None without a limit
    warnings : number of warnings
    dated : whether a date to inspect before is told, see `outlook.dated`
    """

    status: str
    provisional: bool
    label: str
    sentence: str
    rank: int
    rank_hours: float
    remaining_hours: Mapping[str, float | None] = field(default_factory=dict)
    inspect_before_hours: float | None = None
    course: Course | None = None
    warnings: int = 0
    dated: bool = True


def fleet_entry(summary: Mapping[str, Any]) -> FleetEntry:
    """Sum up a summary for a list of drives.

    Parameters
    ----------
    summary : content of a summary.json of `hdprog run` or `hdprog fit`
    """
    verdict, forecasts = summary["verdict"], summary["forecast"]
    first = first_forecast(forecasts)
    remaining = {} if first is None else first["remaining_hours"]
    dated = summary.get("dated", True)  # which earlier versions did not say
    next_test = None if dated else summary.get("next_test_hours")
    rank, hours = _rank(verdict["status"], first, next_test)
    return FleetEntry(
        status=verdict["status"],
        provisional=verdict["provisional"],
        label=verdict["label"],
        sentence=_sentence(verdict),
        rank=rank,
        rank_hours=hours,
        remaining_hours={name: remaining.get(name) for name in ("q05", "q50", "q95") if remaining},
        inspect_before_hours=None if first is None else first["inspect_before_hours"],
        course=_course(summary),
        warnings=len(_warnings(summary)),
        dated=dated,
    )


def _warnings(summary: Mapping[str, Any]) -> set[str]:
    """The different warnings of a drive: its own, its trend's and its tests'."""
    trend = summary.get("trend") or {}
    said = [summary["warnings"], trend.get("warnings", ())]
    said += [test["warnings"] for test in summary["tests"]]
    return {text for texts in said for text in texts}


def first_forecast(forecasts: list[dict[str, Any]]) -> dict[str, Any] | None:
    """Find the forecast of the first of all limits."""
    if not forecasts:
        return None
    return next((one for one in forecasts if one["quantity"] == FIRST_LIMIT), forecasts[0])


def _rank(
    status: str, first: Mapping[str, Any] | None, next_test: float | None
) -> tuple[int, float]:
    """Rank, and hours within it: to the next test where no inspection has a date before it."""
    rank = _RANKS[status]
    if first is None:
        return rank, 0.0
    inspect, now = first["inspect_before_hours"], first["now_hours"]
    if status == "act":
        # Of two drives past their limits the one that is more surely so comes first.
        return (_PASSED if first["already_crossed"] else _DUE), -_risk_now(first)
    if next_test is not None:
        return rank, next_test - now
    if inspect is not None:
        return rank, inspect - now
    return rank, first["horizon_hours"] - now - first["probability_crossed_by_horizon"]


def _risk_now(forecast: Mapping[str, Any]) -> float:
    table = forecast["crossing_probability"]
    return float(table[0][1]) if table else 0.0


def _sentence(verdict: Mapping[str, Any]) -> str:
    """Give the first sentence that tells of the drive, and whether it rests on a pace not seen."""
    # Summaries of long ago have the text alone, where a test's name may look like an end.
    sentences = list(verdict.get("sentences") or _SENTENCE_END.split(verdict["text"]))
    no_pace = [text for text in sentences[:-1] if text.startswith(_NO_PACE)]
    while len(sentences) > 1 and sentences[0].startswith(_CAVEATS):
        del sentences[0]
    return tidy(" ".join([sentences[0], *(_shortened(text) for text in no_pace)]))


def without_pace(sentence: str) -> str:
    """A row's sentence without what its pace rests on, which a whole verdict says by itself."""
    starts = [at for words in _NO_PACE if (at := sentence.find(f" {words}")) > 0]
    return sentence[: min(starts, default=len(sentence))]


def _shortened(no_pace: str) -> str:
    """What a forecast from one test rests on, for a row: where its pace comes from."""
    return no_pace.replace(", not from the drive.", ".")


def _course(summary: Mapping[str, Any]) -> Course | None:
    """Find the course of the figure that is nearest to its limit, with the effects that count."""
    tests, trend = summary["tests"], summary.get("trend") or {}
    limited = [one for one in summary["forecast"] if one["quantity"] != FIRST_LIMIT]
    if not limited:
        return None

    def nearness(forecast: Mapping[str, Any]) -> tuple[bool, float, float]:
        median = forecast["remaining_hours"].get("q50")
        late = float("inf") if median is None else float(median)
        return not forecast["already_crossed"], late, -forecast["probability_crossed_by_horizon"]

    lead = min(limited, key=nearness)
    key = figure_key(lead["quantity"], lead["at_torque_Nm"])
    found = []
    for test in tests:
        figures = test["figures"]
        if trend.get("followed_effects"):
            figures = figures | (test.get("figures_with_effects") or {})
        if test["service_hours"] is not None:
            found.append((test["service_hours"], figures.get(key, {}).get("q50")))
    with shown_in(ReportSettings(**summary.get("report", {}))):
        named = quantity(key)
    points = tuple(
        (float(hours), named.factor * float(value)) for hours, value in found if value is not None
    )
    return Course(named.name, named.unit, points, named.factor * float(lead["limit"]))
