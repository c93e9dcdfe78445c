"""Are forecasts right from the loops on? Simulated drives through fit, trend and forecast.

    python -m tests.benchmarks.end_to_end.run --drives 300 --workers 2
    python -m tests.benchmarks.end_to_end.run --summary

Every test of a drive is fitted as `hdprog run --quick` fits it, the trend links the posteriors, and
the forecast is made. Ranked among 383 paths: the trend's hyperparameters, the state just after the
last test, the figures then, half-way to the horizon and at it; and of each limit the probability
integral transform of the true crossing. Where a drive does not cross before the horizon, its place
is drawn evenly among what is left past it. Every finished drive is a line of results/drives.jsonl,
so that a run that was broken off goes on where it ended. Then results/summary.json and
results/summary.md are made anew.
"""

from __future__ import annotations

import argparse
import json
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.forecast.crossing import forecast
from hdprog.forecast.scores import probability_integral_transform
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.sampling_plan import QUICK
from hdprog.parallel import prepare_numerics
from hdprog.physics.figures import FigureRequest
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.fitting import fit_trend
from hdprog.trend.loop_evidence import FittedLoop
from hdprog.trend.state_space import HYPERPARAMETERS, LOAD_SHARE
from hdprog.trend.trend import Trend
from tests.benchmarks.code_state import digest, imported_by, prior_file
from tests.benchmarks.end_to_end.drives import (
    DRIVE,
    LATER,
    LIMITS,
    NOW,
    OPERATION,
    Drawn,
    draw,
    fit_rng,
    loop_prior,
    wear_prior,
)
from tests.benchmarks.end_to_end.summary import HIGHEST, in_words, summary

RESULTS = Path(__file__).parent / "results"
NARROW = 0.7
"""A planted fault: draws that lie about their median this much closer than they should."""
_JUST_AFTER = 1e-6  # hours past the last test


@lru_cache(maxsize=1)
def state_of_code() -> str:
    """Digest of the sources that the outcome hangs on."""
    files = imported_by(
        "hdprog.forecast.crossing",
        "hdprog.forecast.scores",
        "hdprog.inference.fit_loop",
        "hdprog.trend.figure_paths",
        "hdprog.trend.fitting",
        "tests.benchmarks.end_to_end.drives",
        but=["hdprog.trend.fleet"],  # these drives have no fleet
    )
    return digest([*files, prior_file("csf-25-80"), prior_file("trend")])


def measured(index: int) -> dict[str, Any]:
    """What becomes of one drive; one that fails must not end the run, and is counted."""
    try:
        return _measured(index)
    except Exception as error:
        return {
            "index": index,
            "code": state_of_code(),
            "failed": f"{type(error).__name__}: {error}",
        }


def _measured(index: int) -> dict[str, Any]:
    """Draw one drive, fit it, forecast, and find where its truth lies."""
    drawn, rng = draw(index), fit_rng(index)
    started = time.process_time()
    fits = [fit_loop(loop, DRIVE, rng, prior=loop_prior(), plan=QUICK) for loop in drawn.loops]
    fitted = time.process_time()
    evidence = [
        FittedLoop.of(fit, float(hours)) for fit, hours in zip(fits, drawn.hours, strict=True)
    ]
    trend = fit_trend(evidence, loop_prior(), wear_prior(), rng, quick=True, alpha=DRIVE.alpha)
    ranks, narrow = _ranks(drawn, trend, rng)
    places = _crossing_places(drawn, trend, rng)
    return {
        "index": index,
        "code": state_of_code(),
        "fits_converged": sum(fit.converged for fit in fits),
        "trend_converged": trend.converged,
        "ranks": ranks,
        "narrow": narrow,
        "crossings": places,
        "seconds": [round(fitted - started, 1), round(time.process_time() - fitted, 1)],
    }


def _ranks(
    drawn: Drawn, trend: Trend, rng: np.random.Generator
) -> tuple[dict[str, int], dict[str, int]]:
    """Ranks of the truth by quantity, and among draws with the planted fault."""
    deviates = trend.met.thinned(HIGHEST, rng).deviates
    draws: dict[str, FloatArray] = {}
    truth: dict[str, float] = {}
    for at, name in enumerate(HYPERPARAMETERS):
        if name != LOAD_SHARE:
            draws[name], truth[name] = deviates[:, at], float(drawn.deviates[at])
    hours = np.array([NOW + _JUST_AFTER, *LATER])
    paths = trend.paths(hours, rng, HIGHEST)
    for at, name in enumerate(NAMES):
        draws[f"{name} now"], truth[f"{name} now"] = paths[:, 0, at], float(drawn.now[at])
    true_path = np.vstack([drawn.now, drawn.later])
    for limit in LIMITS:
        request = FigureRequest.of(limit)
        values = figure_paths(request, paths, loop_prior(), OPERATION)
        right = figure_paths(request, true_path, loop_prior(), OPERATION)
        for at, when in enumerate(("now", "half-way", "at the horizon")):
            name = f"{limit.key} {when}"
            draws[name], truth[name] = values[:, at], float(right[at])
    ranks = {name: _rank(truth[name], values, rng) for name, values in draws.items()}
    narrow = {}
    for name, values in draws.items():
        middle = np.median(values)
        narrow[name] = _rank(truth[name], middle + NARROW * (values - middle), rng)
    return ranks, narrow


def _rank(truth: float, draws: FloatArray, rng: np.random.Generator) -> int:
    """How many draws lie below; among those equal to it, at bounds of states, by lot."""
    return int((draws < truth).sum() + rng.integers((draws == truth).sum() + 1))


def _crossing_places(
    drawn: Drawn, trend: Trend, rng: np.random.Generator
) -> dict[str, float | None]:
    """By limit the truth's place in the forecast; None where the limit was passed by now."""
    places: dict[str, float | None] = {}
    for found in forecast(trend, DRIVE, OPERATION, rng):
        if found.limit is None:
            continue
        at = LIMITS.index(found.limit)
        key = f"crossing of {found.limit.key}"
        if drawn.past[at] or found.already_crossed:
            places[key] = None
            continue
        hours, probability = found.crossing_probability.T
        # Limits that are truly passed by now have no place: the others' is among what is to come.
        probability = (probability - probability[0]) / (1.0 - probability[0])
        place = probability_integral_transform(
            hours, probability, drawn.crossings[at], rng.uniform()
        )
        places[key] = round(float(place), 4)
    return places


def run(count: int, file: Path, workers: int) -> None:
    """Measure what the file does not hold yet and append it."""
    done = {one["index"] for one in read(file)}
    left = [index for index in range(count) if index not in done]
    print(f"{count} drives asked for, {len(left)} of them to do")
    file.parent.mkdir(parents=True, exist_ok=True)
    with (
        ProcessPoolExecutor(workers, initializer=prepare_numerics) as executor,
        file.open("a", encoding="utf-8") as stream,
    ):
        futures = [executor.submit(measured, index) for index in left]
        try:
            for number, future in enumerate(as_completed(futures), 1):
                stream.write(json.dumps(future.result()) + "\n")
                stream.flush()
                print(f"{number}/{len(left)}", flush=True)
        finally:
            executor.shutdown(wait=True, cancel_futures=True)


def read(file: Path) -> list[dict[str, Any]]:
    """What a file holds; says so where some of it comes from another state of the code."""
    lines = file.read_text("utf-8").splitlines() if file.exists() else []
    found = [json.loads(line) for line in lines if line.endswith("}")]
    others = sum(one["code"] != state_of_code() for one in found)
    if others:
        print(f"{others} drives of {file} come from another state of the code; delete it to renew")
    return found


def main() -> None:
    """Run what is asked and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=300)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--summary", action="store_true", help="only make the summary anew")
    asked = parser.parse_args()
    file = RESULTS / "drives.jsonl"
    if not asked.summary:
        run(asked.drives, file, asked.workers)
    result = summary(sorted(read(file), key=lambda one: one["index"]))
    atomic_write_text(RESULTS / "summary.json", json.dumps(result, indent=1) + "\n")
    atomic_write_text(RESULTS / "summary.md", in_words(result))
    print(in_words(result))


if __name__ == "__main__":
    main()
