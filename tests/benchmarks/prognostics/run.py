"""Forecasts of remaining life on simulated fleets: hdprog, other packages and an oracle.

    python -m tests.benchmarks.prognostics.run
    python -m tests.benchmarks.prognostics.run --bound
    python -m tests.benchmarks.prognostics.run --summary

Needs the packages of tests/benchmarks/prognostics/requirements.txt. Each fleet is a line of
results/fleets.jsonl, so that a run that was broken off goes on where it ended; fleets from another
state of the code are made anew. The same of the best forecast that is not told the law, which
hangs neither on hdprog's trend nor on other packages, in results/law_not_told.jsonl. Then
results/summary.md and reports/guide/prognostics.png are made anew.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.parallel import prepare_numerics
from tests.benchmarks.code_state import digest, imported_by, prior_file
from tests.benchmarks.prognostics import law_not_told
from tests.benchmarks.prognostics.fleets import KINDS, SEED, Fleet, Kind, fleet
from tests.benchmarks.prognostics.laws import LAWS, Law
from tests.benchmarks.prognostics.method import GRID, Method
from tests.benchmarks.prognostics.oracle import oracle
from tests.benchmarks.prognostics.picture import write_picture
from tests.benchmarks.prognostics.scoring import score
from tests.benchmarks.prognostics.summary import ORACLE, in_words

RESULTS = Path(__file__).parent / "results"
FLEETS = RESULTS / "fleets.jsonl"
NOT_TOLD = RESULTS / "law_not_told.jsonl"
PICTURE = Path(__file__).parents[3] / "reports" / "guide" / "prognostics.png"
_HERE = "tests.benchmarks.prognostics"
_PEERS = ("progpy_filter", "statsmodels_trend", "straight_line", "surpyval_models")
Result = dict[str, Any]


@lru_cache(maxsize=1)
def state_of_code() -> str:
    """Digest of the sources that a fleet's scores hang on."""
    scored = (f"{_HERE}.{name}" for name in ("hdprog_trend", *_PEERS, "oracle", "scoring"))
    packages = Path(__file__).parent / "requirements.txt"
    return digest([*imported_by(*scored), packages, prior_file("trend")])


@lru_cache(maxsize=1)
def state_of_bound() -> str:
    """The same of the scores of the best forecast that is not told the law."""
    return digest(imported_by(*(f"{_HERE}.{name}" for name in ("law_not_told", "scoring"))))


def methods() -> dict[str, Method]:
    """All methods but the oracle and the bound; the other packages are needed only here."""
    from tests.benchmarks.prognostics import (
        hdprog_trend,
        progpy_filter,
        statsmodels_trend,
        straight_line,
        surpyval_models,
    )

    each = (hdprog_trend, surpyval_models, progpy_filter, statsmodels_trend, straight_line)
    return {module.__name__.rsplit(".", 1)[1]: module.learn for module in each}


def measured(one: Fleet, each: dict[str, Method], code: str) -> Result:
    """Forecast a fleet's new units by all methods and score them."""
    seed = [SEED, [law.name for law in LAWS].index(one.law), one.size, one.number]
    units: list[dict[str, Any]] = []
    deviates = np.random.default_rng([*seed, 1]).uniform(size=len(one.new))
    for at, unit in enumerate(one.new):
        known = oracle(one.population, unit.readings, GRID, np.random.default_rng([*seed, 2, at]))
        found = score(known.probability, unit.crossing, deviates[at])
        units.append(
            {
                "remaining": round(found.remaining, 2),
                "worth": round(known.worth),
                "told": {ORACLE: [round(found.transform, 4), round(found.crps, 3)]},
            }
        )
    marked, seconds = {}, {}
    for number, (name, learn) in enumerate(each.items()):
        started = time.process_time()
        learnt = learn(one.others, np.random.default_rng([*seed, 3, number]))
        marks = learnt.not_converged
        for at, unit in enumerate(one.new):
            rng = np.random.default_rng([*seed, 4, number, at])
            told = learnt.forecast(unit.readings, rng)
            marks += not told.converged
            for variant, probability in told.by_name.items():
                found = score(probability, unit.crossing, deviates[at])
                units[at]["told"][variant] = [round(found.transform, 4), round(found.crps, 3)]
        marked[name] = marks
        seconds[name] = round(time.process_time() - started, 2)
    return {
        "law": one.law,
        "size": one.size,
        "number": one.number,
        "code": code,
        "units": units,
        "not_converged": marked,
        "seconds": seconds,
    }


def to_do() -> Iterator[tuple[Law, Kind, int]]:
    """All fleets, laws and sizes in turn, so that a part of a run has its share of each."""
    all_of_them = [
        ((number + 1) / kind.fleets, kind.size, LAWS.index(law), law, kind, number)
        for kind in KINDS
        for law in LAWS
        for number in range(kind.fleets)
    ]
    for *_, law, kind, number in sorted(all_of_them, key=lambda row: row[:3]):
        yield law, kind, number


def read(file: Path) -> list[Result]:
    """The results so far."""
    if not file.exists():
        return []
    return [json.loads(line) for line in file.read_text("utf-8").splitlines()]


def complete(file: Path, each: dict[str, Method], code: str) -> None:
    """Run the fleets that a file lacks or has from another state of the code."""
    kept = [one for one in read(file) if one["code"] == code]
    atomic_write_text(file, "".join(json.dumps(one) + "\n" for one in kept))
    done = {place(one) for one in kept}
    for law, kind, number in to_do():
        if (law.name, kind.size, number) in done:
            continue
        found = measured(fleet(law, kind.size, number, kind.new), each, code)
        with file.open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(found) + "\n")
        print(f"{law.name}, {kind.size} units, fleet {number}: {found['seconds']}", flush=True)


def place(one: Result) -> tuple[str, int, int]:
    """Which fleet a result is of."""
    return one["law"], one["size"], one["number"]


def joined(fleets: Sequence[Result], bounds: Sequence[Result]) -> list[Result]:
    """Results of the fleets, with those of the bound where there are any."""
    bound_of = {place(one): one for one in bounds}
    for one in fleets:
        bound = bound_of.get(place(one))
        if bound is not None:
            for unit, same in zip(one["units"], bound["units"], strict=True):
                unit["told"] |= same["told"]
            one["not_converged"] |= bound["not_converged"]
            one["seconds"] |= bound["seconds"]
    return list(fleets)


def main() -> None:
    """Run what is missing and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bound", action="store_true", help="only run what is not told the law")
    parser.add_argument("--summary", action="store_true", help="only make the summary anew")
    asked = parser.parse_args()
    prepare_numerics()
    if not asked.summary:
        complete(NOT_TOLD, {"law_not_told": law_not_told.learn}, state_of_bound())
        if not asked.bound:
            complete(FLEETS, methods(), state_of_code())
    fleets, bounds = read(FLEETS), read(NOT_TOLD)
    if not fleets:
        raise SystemExit(f"no results in {FLEETS}")
    outdated = any(one["code"] != state_of_code() for one in fleets)
    outdated |= any(one["code"] != state_of_bound() for one in bounds)
    results = joined(fleets, bounds)
    words = in_words(results, outdated)
    atomic_write_text(RESULTS / "summary.md", words)
    write_picture(results, PICTURE)
    print(words)


if __name__ == "__main__":
    main()
