"""Forecasts on published degradation data.

    python -m tests.benchmarks.degradation.run --data DIR

DIR holds gaaslaser.csv, alloya.csv and metalwear.csv (Meeker & Escobar, Statistical Methods for
Reliability Data, 1998; R package SMRD); they are no part of the project. Every unit's first
readings are fitted with the trend that drives are followed with, the later ones are forecast: by
itself, with what the full series of the other units say, and by a straight line. Written to
tests/benchmarks/degradation/results/summary.json and summary.md.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.parallel import prepare_numerics
from tests.benchmarks.degradation.series import STUDIES, read_series
from tests.benchmarks.degradation.study import ALONE, LINE, POOLED, Score, forecasts

RESULTS = Path(__file__).parent / "results"
SEED = 83


def summed(scores: list[Score]) -> dict[str, Any]:
    """Shares held, mean score, and how many there were."""
    readings = np.concatenate([one.readings for one in scores])
    crossings = np.array([one.crossing for one in scores if one.crossing is not None])
    return {
        "units": len(scores),
        "not_converged": sum(not one.converged for one in scores),
        "readings": _three(readings),
        "crossings": _three(crossings) if crossings.size else None,
    }


def _three(rows: np.ndarray) -> dict[str, float | int | None]:
    wide, narrow, score = (float(value) for value in rows.mean(axis=0))
    known = np.isfinite(wide)
    return {
        "count": len(rows),
        "held_by_90": round(wide, 3) if known else None,
        "held_by_50": round(narrow, 3) if known else None,
        "score": round(score, 4),
    }


def in_words(results: dict[str, Any]) -> str:
    """The summary as a page."""
    lines = [
        "# Forecasts on published degradation data",
        "",
        f"`{results['command']}`",
        "",
        "Score: mean CRPS of the forecast, absolute error of the line; of readings in ways from "
        "start to failure, of crossings in planned test times. Crossings are those that a unit's "
        "own readings show after the part that the forecast is told.",
        "",
        "| data | forecast | readings | 90 % holds | 50 % holds | score | crossings | 90 % holds | "
        "50 % holds | score |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, methods in results["studies"].items():
        for method, found in methods.items():
            cells = [name, method]
            for part in ("readings", "crossings"):
                one = found[part]
                cells += (
                    ["–"] * 4
                    if one is None
                    else [
                        str(one["count"]),
                        _percent(one["held_by_90"]),
                        _percent(one["held_by_50"]),
                        f"{one['score']:.4f}",
                    ]
                )
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{share:.0%}"


def main() -> None:
    """Run the studies and write what came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    options = parser.parse_args()
    prepare_numerics()
    results: dict[str, Any] = {
        "command": "python -m tests.benchmarks.degradation.run --data DIR",
        "seed": SEED,
        "studies": {},
    }
    for study in STUDIES:
        scores: dict[str, list[Score]] = {ALONE: [], POOLED: [], LINE: []}
        for unit, found in forecasts(study, read_series(study, options.data), SEED):
            for score in found:
                scores[score.method].append(score)
            print(f"{study.name}: {unit}", flush=True)
        results["studies"][study.name] = {name: summed(each) for name, each in scores.items()}
    atomic_write_text(RESULTS / "summary.json", json.dumps(results, indent=1) + "\n")
    atomic_write_text(RESULTS / "summary.md", in_words(results))
    print(in_words(results))


if __name__ == "__main__":
    main()
