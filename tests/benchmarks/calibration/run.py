"""Calibration of the loop posterior by simulation.

    python -m tests.benchmarks.calibration.run --loops 1000 --workers 2
    python -m tests.benchmarks.calibration.run --summary
    python -m tests.benchmarks.calibration.run --rerun 17

A loop goes through what `hdprog fit --quick` does: noise found from the record, spikes set aside,
the decision between white and correlated noise, the sampling until converged. The quick plan asks
for 400 effective draws of each coordinate and for chains 50 autocorrelation times long; the ranks
are taken among 383 of them that are as good as independent. Every finished loop is a line of
results/loops.jsonl, so that a run that was broken off goes on where it ended; loops that failed are
tried again. Then results/summary.json, results/summary.md and the picture
reports/guide/calibration.png are made anew.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import prepare, settle_noise
from hdprog.inference.sampling_plan import QUICK
from hdprog.parallel import prepare_numerics
from tests.benchmarks.calibration import Outcome, read_outcomes
from tests.benchmarks.calibration.faults import (
    INTERVALS,
    SLIP,
    WEIGHTED,
    log_weights,
    shares_with,
    with_fixed_slip,
)
from tests.benchmarks.calibration.loops import DRIVE, KINDS, PRIOR, draw, fit_rng, kind_of
from tests.benchmarks.calibration.picture import write_picture
from tests.benchmarks.calibration.ranks import located, rank_of
from tests.benchmarks.calibration.summary import in_words, summary
from tests.benchmarks.code_state import digest, imported_by, prior_file
from tests.benchmarks.rounded import rounded

RESULTS = Path(__file__).parent / "results"
PICTURE = Path(__file__).parents[3] / "reports" / "guide" / "calibration.png"
REFITTED = 4
"""One in so many loops of each kind is fitted once more with the slip fixed."""


@lru_cache(maxsize=1)
def state_of_code() -> str:
    """Digest of the sources that the outcome hangs on."""
    here = [f"tests.benchmarks.calibration.{name}" for name in ("faults", "loops", "ranks")]
    return digest([*imported_by("hdprog.inference.fit_loop", *here), prior_file(PRIOR)])


def measured(index: int, code: str, *, refit: bool) -> Outcome:
    """Draw one loop, fit it, and find where its truth lies."""
    drawn = draw(index)
    outcome = Outcome(
        index,
        code,
        kind=drawn.kind,
        one_sided=drawn.one_sided,
        readings=len(drawn.loop),
        noise_rad=drawn.noise,
        largest_torque=drawn.largest_torque,
        T_i=float(drawn.parameters["T_i"][0]),
    )
    try:
        rng = fit_rng(index)
        started = time.process_time()
        prepared = prepare(drawn.loop, DRIVE, rng, prior=drawn.prior)
        likelihood, starts = settle_noise(prepared.likelihood, prepared.starts, rng)
        posterior = sample_posterior(prepared, likelihood, starts, rng, plan=QUICK)
        outcome.processor_seconds["fit"] = time.process_time() - started
        _describe(outcome, posterior)
        started = time.process_time()
        found = located(drawn, posterior)
        outcome.ranks, outcome.shares = found.ranks(rng), found.shares()
        for fault in (*WEIGHTED, INTERVALS):
            outcome.faults[fault] = _as_ranks(shares_with(fault, found, likelihood))
        for fault in WEIGHTED:
            outcome.efficiency[fault] = _efficiency(log_weights(fault, found.points, likelihood))
        outcome.processor_seconds["ranks"] = time.process_time() - started
        if refit:
            started = time.process_time()
            wrong = with_fixed_slip(prepared, fit_rng(index, 1), QUICK)
            outcome.faults[SLIP] = _as_ranks(located(drawn, wrong).shares())
            outcome.slip_converged = wrong.converged
            outcome.slip_correlated = wrong.likelihood.noise.whitening is not None
            outcome.processor_seconds["refit"] = time.process_time() - started
    except Exception as error:  # one loop that fails must not end the run; it is counted
        outcome.status, outcome.reason = "failed", f"{type(error).__name__}: {error}"
    return outcome


def _as_ranks(shares: list[float]) -> list[int]:
    return [rank_of(share) for share in shares]


def _describe(outcome: Outcome, posterior: Posterior) -> None:
    """Fill in what the fit says of itself."""
    diagnostics = posterior.diagnostics
    outcome.converged = posterior.converged
    outcome.correlated = posterior.likelihood.noise.whitening is not None
    outcome.spikes = int((~posterior.kept).sum())
    outcome.ess = float(min(diagnostics.ess_bulk.min(), diagnostics.ess_tail.min()))
    outcome.rhat = float(diagnostics.rhat.max())
    outcome.autocorrelation_time = float(posterior.sampling["autocorrelation_time"])


def _efficiency(log_weight: np.ndarray) -> float:
    """Effective share of draws with these log weights."""
    weights = np.exp(log_weight - log_weight.max())
    return round(float(weights.sum() ** 2 / (weights**2).sum() / weights.size), 4)


def is_refitted(index: int) -> bool:
    """Whether a loop is fitted once more with the slip fixed."""
    return (index // len(KINDS)) % REFITTED == 0


def outcomes(loops: Sequence[int], workers: int) -> Iterator[Outcome]:
    """Outcomes as they come."""
    code = state_of_code()
    with ProcessPoolExecutor(workers, initializer=prepare_numerics) as executor:
        futures = [
            executor.submit(measured, index, code, refit=is_refitted(index)) for index in loops
        ]
        try:
            for future in as_completed(futures):
                yield future.result()
        finally:
            executor.shutdown(wait=True, cancel_futures=True)


def run(count: int, file: Path, workers: int) -> None:
    """Measure what the file does not hold yet and append it."""
    old, unreadable = read_outcomes(file)
    done = {one.index for one in old if one.status != "failed"}
    left = [index for index in range(count) if index not in done]
    others = sum(one.code != state_of_code() for one in old)
    print(f"{count} loops asked for, {len(left)} of them to do")
    if others:
        print(f"{others} loops of {file} come from another state of the code; delete it to renew")
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a", encoding="utf-8") as stream:
        if old or unreadable:  # the last line may have been broken off
            stream.write("" if file.read_bytes().endswith(b"\n") else "\n")
        for number, one in enumerate(outcomes(left, workers), 1):
            stream.write(json.dumps(rounded(asdict(one))) + "\n")
            stream.flush()
            print(f"{number}/{len(left)} {one.words}", flush=True)


def main() -> None:
    """Run what is asked and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--loops", type=int, default=1000, metavar="N", help="of all kinds in turn")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--file", type=Path, default=RESULTS / "loops.jsonl")
    parser.add_argument("--picture", type=Path, default=PICTURE)
    parser.add_argument("--summary", action="store_true", help="only make the summary anew")
    parser.add_argument("--rerun", type=int, metavar="INDEX", help="run one, keep nothing")
    asked = parser.parse_args()
    if asked.rerun is not None:
        print(f"loop {asked.rerun}, {kind_of(asked.rerun)}")
        print(json.dumps(asdict(measured(asked.rerun, state_of_code(), refit=True)), indent=1))
        return
    if not asked.summary:
        run(asked.loops, asked.file, asked.workers)
    found, unreadable = read_outcomes(asked.file)
    if not any(one.status == "fitted" for one in found):
        raise SystemExit(f"no fitted loops in {asked.file}")
    result = summary(found, unreadable)
    folder = asked.file.parent
    atomic_write_text(folder / "summary.json", json.dumps(result, indent=1) + "\n")
    atomic_write_text(folder / "summary.md", in_words(result))
    write_picture(found, result, asked.picture)
    print(in_words(result))


if __name__ == "__main__":
    main()
