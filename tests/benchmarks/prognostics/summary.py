"""What came out, in words and tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from tests.benchmarks.prognostics.fleets import HORIZON, KINDS, NOW, SEED
from tests.benchmarks.prognostics.laws import LAWS
from tests.benchmarks.prognostics.scoring import (
    BINS,
    COVERAGE_AIM,
    CRPS_AIM,
    Score,
    Summary,
    summarised,
)

COMMAND = "python -m tests.benchmarks.prognostics.run"
ORACLE, NOT_TOLD, HDPROG = "oracle", "law not told", "hdprog"
METHODS = {
    ORACLE: "the law and its population known; nobody can do better on average",
    NOT_TOLD: "the six laws and how their populations are drawn are known, not which of "
    "them it is: nobody who is not told can do better on average",
    HDPROG: "trend with the shipped wear prior and what the other units' readings say of it",
    "hdprog, level pace": "the same, without the rise of pace that is expected of gears past the "
    "last test",
    "hdprog, no fleet": "trend of the new unit's readings alone",
    "SurPyval linear path": "linear paths, their population as prior of the new unit's",
    "SurPyval best path": "the same with the path of least AICc",
    "SurPyval Wiener": "Wiener process of all readings, first passage from the last reading",
    "ProgPy": "unscented Kalman filter of a figure that grows at a wandering pace, Monte Carlo "
    "prediction; its noises and its start by moments of the other units' readings",
    "statsmodels": "local linear trend of the new unit's readings, simulated",
    "straight line": "least squares through the new unit's readings, prediction interval",
}
Result = dict[str, Any]


def scores_of(results: Iterable[Result], method: str) -> tuple[list[Score], list[Score]]:
    """A method's scores and the oracle's for the units that it forecast."""
    own, known = [], []
    for one in results:
        for unit in one["units"]:
            if method in unit["told"]:
                own.append(Score(*unit["told"][method], unit["remaining"]))
                known.append(Score(*unit["told"][ORACLE], unit["remaining"]))
    return own, known


def summary_of(results: Iterable[Result], method: str) -> Summary | None:
    """Of one method over some fleets; None where it forecast no unit."""
    own, known = scores_of(results, method)
    return summarised(own, known) if own else None


def in_words(results: Sequence[Result], outdated: bool) -> str:
    """The results as Markdown.

    Parameters
    ----------
    results : of the fleets so far
    outdated : whether some come from another state of the code
    """
    parts = [_head(results, outdated), _aims(results), _by_size(results)]
    parts += [_by_law(results, kind.size) for kind in KINDS]
    parts += [_methods(), _transforms(results), _marks(results)]
    return "\n\n".join(parts) + "\n"


def _head(results: Sequence[Result], outdated: bool) -> str:
    planned = sum(kind.fleets for kind in KINDS) * len(LAWS)
    units = sum(len(one["units"]) for one in results)
    never = sum(unit["remaining"] >= HORIZON - NOW for one in results for unit in one["units"])
    worth = min(unit["worth"] for one in results for unit in one["units"])
    words = (
        "# Remaining life on simulated fleets: hdprog, other packages and an oracle\n\n"
        f"`{COMMAND}`, seed {SEED}: {len(results)} of {planned} fleets, {units} new units to "
        "forecast.\n\n"
        "A figure begins at 0 and fails at 1, by the laws of laws.py. A fleet of 3, 6 or 40 are "
        "that many units tested ten times, from 1 to 900 h of a planned life of 1 000 h; a new "
        f"unit is seen five times, up to {NOW:g} h, and its remaining life is forecast. The truth "
        "is the first crossing of its own course without noise.\n\n"
        f"Crossings are looked for up to {HORIZON:g} h. One after that counts as never, and what "
        f"a forecast puts there, too; {never} units never cross. The CRPS is the integral up to "
        f"that hour and true remaining life is at most {HORIZON - NOW:g} h, for every method "
        "alike. Every method is told that the unit has not failed yet. A central interval holds "
        "the truth where the truth's probability integral transform lies between its levels, "
        "drawn at random inside the lump of never. The oracle's least effective number of draws "
        f"is {worth}."
    )
    without = sum(NOT_TOLD not in unit["told"] for one in results for unit in one["units"])
    if without:
        words += f" {NOT_TOLD.capitalize()}: still to be run for {without} of the new units."
    if outdated:
        words += "\n\n**Some fleets come from another state of the code.**"
    return words


def _aims(results: Sequence[Result]) -> str:
    low, high = COVERAGE_AIM
    rows = []
    for kind in KINDS:
        found = summary_of(_of_size(results, kind.size), HDPROG)
        if found is None:
            continue
        least, most = found.range_90
        sharp = f"{found.ratio:.2f}: {_met(found.sharp)}"
        rows.append(
            [
                str(kind.size),
                str(found.units),
                f"{found.held_90:.1%} ({least:.1%} to {most:.1%}): {_met(found.covers)}",
                sharp if kind.size == 3 else f"{found.ratio:.2f}",
                _met(found.histogram.inside),
            ]
        )
    return (
        f"## hdprog against the aims\n\nThe 90 % interval holds {low:.0%} to {high:.0%} (in "
        "brackets the 95 % range of the share); mean CRPS within "
        f"{CRPS_AIM:.2f} of the oracle's, asked for at 3 units; all {BINS} bins of the transforms' "
        "histogram inside its 95 % band, which is wide where forecasts are few.\n\n"
        + _table(["units", "forecasts", "90 % holds", "CRPS over the oracle's", "transforms"], rows)
    )


def _met(met: bool) -> str:
    return "met" if met else "**NOT met**"


def _of_size(results: Iterable[Result], size: int) -> list[Result]:
    return [one for one in results if one["size"] == size]


def _each(results: Sequence[Result]) -> Iterator[tuple[int, str, Summary]]:
    """Size, method and scores of all that were scored."""
    for kind in KINDS:
        some = _of_size(results, kind.size)
        for method in METHODS:
            found = summary_of(some, method)
            if found is not None:
                yield kind.size, method, found


def _by_size(results: Sequence[Result]) -> str:
    rows = [
        [str(size), method, str(found.units), *_cells(found)]
        for size, method, found in _each(results)
    ]
    return (
        "## All laws\n\nCRPS: mean of CRPS over true remaining life. Over the oracle's: ratio of "
        "the mean CRPS in hours.\n\n" + _table(["units", "method", "forecasts", *_COLUMNS], rows)
    )


_COLUMNS = ("90 % holds", "50 % holds", "CRPS", "over the oracle's", "transforms in their band")


def _cells(found: Summary) -> list[str]:
    return [
        f"{found.held_90:.1%}",
        f"{found.held_50:.1%}",
        f"{found.relative:.3f}",
        f"{found.ratio:.2f}",
        "yes" if found.histogram.inside else "no",
    ]


def _by_law(results: Sequence[Result], size: int) -> str:
    some = _of_size(results, size)
    rows = []
    for method in METHODS:
        row = [method]
        for law in LAWS:
            found = summary_of((one for one in some if one["law"] == law.name), method)
            row.append(
                "–"
                if found is None
                else f"{found.held_90:.0%}, {found.held_50:.0%}, {found.relative:.3f}, "
                f"{found.ratio:.2f}"
            )
        rows.append(row)
    counts = ", ".join(
        f"{sum(len(one['units']) for one in some if one['law'] == law.name)} ({law.name})"
        for law in LAWS
    )
    return (
        f"## By law, {size} units\n\nShare that the 90 % and the 50 % intervals hold, CRPS over "
        f"true remaining life, ratio of mean CRPS to the oracle's. New units: {counts}.\n\n"
        + _table(["method", *(law.name for law in LAWS)], rows)
    )


def _methods() -> str:
    return "## Methods\n\n" + "\n".join(f"* {name}: {words}." for name, words in METHODS.items())


def _transforms(results: Sequence[Result]) -> str:
    rows = []
    for size, method, found in _each(results):
        band = f"{found.histogram.low} to {found.histogram.high}"
        counts = " ".join(str(count) for count in found.histogram.counts)
        rows.append([str(size), method, counts, band])
    return (
        "## Probability integral transforms\n\nForecasts in each tenth, and the band that holds "
        "all ten in 95 % of studies of a calibrated forecast. Many in the first tenths: failures "
        "come sooner than forecast; in the last: later.\n\n"
        + _table(["units", "method", "tenths", "band"], rows)
    )


def _marks(results: Sequence[Result]) -> str:
    names = dict.fromkeys(name for one in results for name in one["seconds"])
    total = sum(len(one["units"]) for one in results)
    rows = [
        [
            name,
            str(sum(one["not_converged"].get(name, 0) for one in results)),
            f"{sum(one['seconds'].get(name, 0.0) for one in results):.0f}",
        ]
        for name in names
    ]
    refused = [
        f"{method} gives none for {total - len(scores_of(results, method)[0])}"
        for method in METHODS
        if method != NOT_TOLD and 0 < len(scores_of(results, method)[0]) < total
    ]
    words = (
        "## Marks\n\nFits, of the other units and of the new ones, that say of themselves that "
        "they did not converge (kept in), and processor seconds."
    )
    if refused:
        words += f" Of the {total} forecasts, {'; '.join(refused)}: left out of its scores."
    return words + "\n\n" + _table(["method", "not converged", "seconds"], rows)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [list(head), ["---"] * len(head), *[list(row) for row in rows]]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
