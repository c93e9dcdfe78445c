"""How well effects are traced, on loops of the independent simulator.

    python -m tests.benchmarks.effects.run --clean 300 --correlated 100 --per-cell 10 --pairs 60
    python -m tests.benchmarks.effects.run --summary
    python -m tests.benchmarks.effects.run --rerun creep@2:0

The simulator shares no code with hdprog and draws the effects in other shapes. The fit is blind: it
gets torque, angle, time, temperature and output angle, the default drive and the prior of a
CSF-25-80. Every finished loop is a line of results/loops.jsonl, so that a run that was broken off
goes on where it ended; loops that failed are tried again. Then results/summary.json,
results/summary.md and the picture reports/guide/effects-confusion.png are made anew.

Asked are numbers of loops: `--clean`, `--correlated` (clean, the noise with memory), `--stepped`
(clean, the angle in steps of six times the noise), `--per-cell` (of every effect and size) and
`--pairs` (two effects). Any loop can be run again with `--rerun`.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.config import Drive
from hdprog.discovery.found import choosing_step
from hdprog.discovery.heldout import held_out
from hdprog.discovery.search import Traced, trace
from hdprog.discovery.separating import indistinguishable
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.parallel import prepare_numerics
from tests.benchmarks.code_state import digest, imported_by
from tests.benchmarks.effects import Outcome, read_outcomes
from tests.benchmarks.effects.loops import (
    CLEAN,
    LISTED,
    UNLISTED,
    Case,
    NotDrawable,
    cases,
    draw,
)
from tests.benchmarks.effects.picture import write_picture
from tests.benchmarks.effects.summary import in_words, summary
from tests.independent.effects import EFFECTS

RESULTS = Path(__file__).parent / "results"
PICTURE = Path(__file__).parents[3] / "reports" / "guide" / "effects-confusion.png"


@lru_cache(maxsize=1)
def state_of_code() -> str:
    """Digest of the sources that the outcome hangs on."""
    return digest(
        imported_by(
            "hdprog.discovery.found",
            "hdprog.discovery.heldout",
            "hdprog.discovery.search",
            "hdprog.discovery.separating",
            "tests.benchmarks.effects.loops",
            "tests.independent.effects",
        )
    )


def measured(case: Case, index: int, code: str) -> Outcome:
    """Draw one loop, trace what it lacks and compare with the truth."""
    outcome = Outcome(case.name, index, code)
    try:
        drawn = draw(case, index)
    except NotDrawable as reason:
        outcome.status, outcome.reason = "not drawable", str(reason)
        return outcome
    outcome.effects = list(drawn.sizes)
    outcome.kind, outcome.readings, outcome.noise_rad = drawn.kind, len(drawn.loop), drawn.noise
    outcome.sizes_rad, outcome.reached = drawn.sizes, drawn.reached
    outcome.decoys, outcome.rejected = list(drawn.decoys), drawn.rejected
    prior = read_prior_file("csf-25-80").prior(None)
    seed = np.random.SeedSequence(int(case.fit_rng(index).integers(2**32)))
    started, busy = time.perf_counter(), time.process_time()
    try:
        prepared = prepare(drawn.loop, Drive.default(), case.fit_rng(index), prior=prior)
        traced = trace([prepared], [seed])[0]
        outcome.seconds = time.perf_counter() - started
        outcome.processor_seconds = time.process_time() - busy
        _judged(outcome, traced)
    except Exception as error:  # one loop that fails must not end the run; it is counted
        outcome.status, outcome.reason = "failed", f"{type(error).__name__}: {error}"
    return outcome


def _judged(outcome: Outcome, traced: Traced) -> None:
    """Fill in what was found and the errors."""
    base, final = traced.base, traced.final
    blocks = base.likelihood.blocks
    outcome.names = list(final.ids)
    outcome.term = None if final.term is None else final.term.coordinate
    outcome.before, outcome.after = base.misfit / blocks, final.misfit / blocks
    outcome.alike = alike(traced)
    outcome.heldout_before = held_out(traced.prepared, base).rmse
    outcome.heldout_after = held_out(traced.prepared, final).rmse
    if len(outcome.effects) == 1:
        oracle = traced.steps[0].models.get(EFFECTS[outcome.effects[0]].identifier)
        if oracle is not None:
            outcome.heldout_oracle = held_out(traced.prepared, oracle).rmse


def alike(traced: Traced) -> list[str]:
    """Effects stated to do as well as the main one on this record."""
    main = traced.final.ids[0] if traced.final.ids else ""
    step = choosing_step(traced.steps, main)
    return [] if step is None else list(indistinguishable([step], main))


def wanted(asked: argparse.Namespace) -> list[tuple[Case, int]]:
    """The loops that are asked for; every case's first loop comes before any second one."""
    every = [*LISTED, *UNLISTED]
    chosen = asked.effects.split(",") if asked.effects else every
    if unknown := set(chosen) - set(every):
        raise SystemExit(f"no such effect: {', '.join(sorted(unknown))}; known: {', '.join(every)}")
    counts = {Case(name): getattr(asked, name) for name in CLEAN}
    counts |= {Case("pair"): asked.pairs}
    counts |= dict.fromkeys(cases(chosen), asked.per_cell)
    loops = [(case, index) for case, count in counts.items() for index in range(count)]
    return sorted(loops, key=lambda loop: loop[1] / counts[loop[0]])


def outcomes(loops: list[tuple[Case, int]], workers: int) -> Iterator[Outcome]:
    """Outcomes as they come."""
    code = state_of_code()
    with ProcessPoolExecutor(workers, initializer=prepare_numerics) as executor:
        futures = [executor.submit(measured, case, index, code) for case, index in loops]
        try:
            for future in as_completed(futures):
                yield future.result()
        finally:
            executor.shutdown(wait=True, cancel_futures=True)


def run(loops: list[tuple[Case, int]], file: Path, workers: int) -> None:
    """Measure what the file does not hold yet and append it."""
    old, unreadable = read_outcomes(file)
    done = {(one.case, one.index) for one in old if one.status != "failed"}
    left = [(case, index) for case, index in loops if (case.name, index) not in done]
    others = sum(one.code != state_of_code() for one in old)
    print(f"{len(loops)} loops asked for, {len(left)} of them to do")
    if others:
        print(f"{others} loops of {file} come from another state of the code; delete it to renew")
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a", encoding="utf-8") as stream:
        if old or unreadable:  # the last line may have been broken off
            stream.write("" if file.read_bytes().endswith(b"\n") else "\n")
        for number, one in enumerate(outcomes(left, workers), 1):
            stream.write(json.dumps(asdict(one)) + "\n")
            stream.flush()
            print(f"{number}/{len(left)} {one.words}", flush=True)


def main() -> None:
    """Run what is asked and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, what in (
        ("clean", "clean loops with white noise"),
        ("correlated", "clean loops with correlated noise"),
        ("stepped", "clean loops whose angle has steps wider than the noise"),
        ("per-cell", "loops of every effect and size"),
        ("pairs", "loops with two effects"),
    ):
        parser.add_argument(f"--{name}", type=int, default=0, metavar="N", help=what)
    parser.add_argument("--effects", metavar="NAMES", help="only these, divided by commas")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--file", type=Path, default=RESULTS / "loops.jsonl")
    parser.add_argument("--picture", type=Path, default=PICTURE)
    parser.add_argument("--summary", action="store_true", help="only make the summary anew")
    parser.add_argument("--rerun", metavar="CASE:INDEX", help="run one, keep nothing")
    asked = parser.parse_args()
    if asked.rerun:
        name, index = asked.rerun.rsplit(":", 1)
        print(json.dumps(asdict(measured(Case(name), int(index), state_of_code())), indent=1))
        return
    if not asked.summary:
        run(wanted(asked), asked.file, asked.workers)
    found, unreadable = read_outcomes(asked.file)
    if not found:
        raise SystemExit(f"no loops in {asked.file}")
    result = summary(found, unreadable)
    folder = asked.file.parent
    atomic_write_text(folder / "summary.json", json.dumps(result, indent=1) + "\n")
    atomic_write_text(folder / "summary.md", in_words(result))
    write_picture(result, asked.picture)
    print(in_words(result))


if __name__ == "__main__":
    main()
