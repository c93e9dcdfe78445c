"""hdprog's sampler against a long reference on ten hard loops.

    python -m tests.benchmarks.modes.run
    python -m tests.benchmarks.modes.run --case one-sided
    python -m tests.benchmarks.modes.run --summary

Needs the packages of tests/benchmarks/modes/requirements.txt. Each finished case is a file of
results/, so that a run that was broken off goes on where it ended; a case from another state of the
code or of the benchmark is made anew. Then results/summary.md and the picture
reports/guide/modes.png are made anew.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from dataclasses import asdict, replace
from datetime import UTC, datetime
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, prepare, settle_noise
from hdprog.inference.sampling_plan import FULL, SamplingPlan
from hdprog.inference.starting_points import StartingPoint, starting_points
from hdprog.parallel import prepare_numerics
from hdprog.physics.parameters import FloatArray
from tests.benchmarks.calibration.loops import DRIVE, PRIOR
from tests.benchmarks.code_state import digest, imported_by, prior_file
from tests.benchmarks.modes.annealed import Reference, anneal
from tests.benchmarks.modes.cases import CASES, Case
from tests.benchmarks.modes.compare import Compared, coordinates, deviations, missed
from tests.benchmarks.modes.coordinates import jacobian_error, systems
from tests.benchmarks.modes.fused import compiled
from tests.benchmarks.modes.nested import Nested, nested
from tests.benchmarks.modes.picture import write_picture
from tests.benchmarks.modes.summary import in_words
from tests.benchmarks.rounded import rounded

RESULTS = Path(__file__).parent / "results"
PICTURE = Path(__file__).parents[3] / "reports" / "guide" / "modes.png"
LONG = replace(FULL, required_ess=20_000.0, most_steps=400_000, stored_steps=1000)
"""Long enough that hdprog's own Monte-Carlo error hides no bias that the limits name."""
FULL_RUNS = 4
"""Runs of the plan that users get; each but the first searches its starts anew."""
HISTOGRAM_BINS = 70
LARGEST_JACOBIAN_ERROR = 1e-5
_JACOBIANS = 1000
_PREPARE, _REFERENCE, _NESTED, _LONG, _FULL = range(5)  # streams of random numbers of a case
_OWN = ("annealed", "cases", "compare", "fused", "nested")


@lru_cache(maxsize=1)
def state_of_code() -> str:
    """Digest of the sources that a case's outcome hangs on."""
    files = imported_by(
        "hdprog.inference.fit_loop",
        *(f"tests.benchmarks.modes.{name}" for name in _OWN),
    )
    packages = Path(__file__).parent / "requirements.txt"
    return digest([*files, Path(__file__), packages, prior_file(PRIOR)])


def measured(case: Case) -> dict[str, Any]:
    """Fit one case in all ways and compare."""
    seconds: dict[str, float] = {}
    loop, prior = case.make()
    rng = case.rng(_PREPARE)
    prepared = prepare(loop, DRIVE, rng, prior=prior)
    likelihood, starts = settle_noise(prepared.likelihood, prepared.starts, rng)
    # The first fit settles what the blocks are worth; all others and the reference share that.
    first = _timed(seconds, "full", lambda: _fit(case, prepared, likelihood, starts, FULL, _FULL))
    likelihood = first.likelihood
    others = _timed(
        seconds,
        "full",
        lambda: [
            _fit(case, prepared, likelihood, starts, FULL, _FULL + number)
            for number in range(1, FULL_RUNS)
        ],
    )
    long = _timed(seconds, "long", lambda: _fit(case, prepared, likelihood, starts, LONG, _LONG))
    runs = {"long": [long], "full": [first, *others]}
    log_likelihood = compiled(likelihood, rng)
    reference = _timed(
        seconds, "reference", lambda: anneal(likelihood, log_likelihood, case.rng(_REFERENCE))
    )
    moved = reference.points[0, :_JACOBIANS]
    jacobian = max(jacobian_error(system, moved) for system in systems(likelihood))
    if not jacobian < LARGEST_JACOBIAN_ERROR:
        raise ValueError(f"{case.name}: a Jacobian of the reference's moves is off by {jacobian:g}")
    check = _timed(seconds, "nested", lambda: nested(likelihood, log_likelihood, case.rng(_NESTED)))
    compared = _timed(
        seconds,
        "comparison",
        lambda: Compared(reference, likelihood, prepared.operation, case.cut),
    )
    return {
        "name": case.name,
        "why": case.why,
        "code": state_of_code(),
        "date": datetime.now(UTC).date().isoformat(),
        "versions": _versions(),
        "readings": len(loop),
        "blocks": likelihood.blocks,
        "correlated": likelihood.noise.whitening is not None,
        "starts": [round(start.deviance - starts[0].deviance, 2) for start in starts],
        "reference": _reference_words(reference, compared, jacobian),
        "nested": _nested_words(check, compared),
        "separators": [asdict(separator) for separator in compared.separators],
        "runs": {
            kind: [_run_words(compared, posterior) for posterior in posteriors]
            for kind, posteriors in runs.items()
        },
        "histograms": _histograms(compared, check, runs),
        "processor_seconds": {part: round(value, 1) for part, value in seconds.items()},
    }


def _timed(seconds: dict[str, float], part: str, work: Any) -> Any:
    started = time.process_time()
    found = work()
    seconds[part] = seconds.get(part, 0.0) + time.process_time() - started
    return found


def _fit(
    case: Case,
    prepared: Prepared,
    likelihood: LoopLikelihood,
    starts: list[StartingPoint],
    plan: SamplingPlan,
    stream: int,
) -> Posterior:
    """hdprog's sampler on the likelihood that the reference has, with random numbers of its own."""
    rng = case.rng(stream)
    if stream > _FULL:
        starts = starting_points(likelihood, rng)
    return sample_posterior(prepared, likelihood, starts, rng, plan=plan)


def _reference_words(reference: Reference, compared: Compared, jacobian: float) -> dict[str, Any]:
    masses, errors = compared.mode_masses
    evidence, evidence_error = reference.evidence
    return {
        "populations": len(reference.log_evidence),
        "draws": int(reference.points.shape[0] * reference.points.shape[1]),
        "log_evidence": evidence,
        "log_evidence_error": evidence_error,
        "memory": float(reference.memory.max()),
        "jacobian_error": jacobian,
        "moments": compared.moments,
        "modes": masses.tolist(),
        "modes_error": errors.tolist(),
    }


def _nested_words(check: Nested, compared: Compared) -> dict[str, Any]:
    """The check's own figures, its errors from realisations of the run."""
    others = [(points, weights) for points, weights in check.realisations]
    mean = check.weights @ check.points
    means = np.array([weights @ points for points, weights in others])
    modes = np.array([compared.modes(points, weights) for points, weights in others])
    sd = np.sqrt(check.weights @ (check.points - mean) ** 2)
    sds = np.array([np.sqrt(w @ (p - w @ p) ** 2) for p, w in others])
    return {
        "log_evidence": check.log_evidence,
        "log_evidence_error": check.error,
        "effective": check.effective,
        "calls": check.calls,
        "mean": mean.tolist(),
        "mean_error": means.std(axis=0, ddof=1).tolist(),
        "sd": sd.tolist(),
        "sd_error": sds.std(axis=0, ddof=1).tolist(),
        "modes": compared.modes(check.points, check.weights).tolist(),
        "modes_error": modes.std(axis=0, ddof=1).tolist(),
    }


def _run_words(compared: Compared, posterior: Posterior) -> dict[str, Any]:
    diagnostics, chains = posterior.diagnostics, posterior.chains
    each = [compared.modes(chain.reshape(-1, chain.shape[-1])) for chain in chains]
    return {
        "converged": posterior.converged,
        "rhat": float(diagnostics.rhat.max()),
        "ess": float(min(diagnostics.ess_bulk.min(), diagnostics.ess_tail.min())),
        "steps": posterior.sampling["steps"],
        "autocorrelation_time": posterior.sampling["autocorrelation_time"],
        "acceptance": posterior.sampling["acceptance"],
        "modes": np.mean(each, axis=0).tolist(),
        "modes_of_ensembles": np.array(each).tolist(),
        "cells": missed(compared, posterior.points),
        "deviations": deviations(compared, chains),
    }


def _histograms(
    compared: Compared, check: Nested, runs: dict[str, list[Posterior]]
) -> list[dict[str, Any]]:
    """Densities in the coordinates that part modes, or in the broadest where none does."""
    chosen = [separator.coordinate for separator in compared.separators[:2]]
    pooled = compared.named
    if not chosen:
        spread = compared.reference.points.reshape(-1, 9).std(axis=0)[:8]
        chosen = [list(pooled)[int(np.argmax(spread / compared.likelihood.prior.sd))]]
    found = []
    for name in chosen:
        edges = np.quantile(pooled[name], [5e-4, 1 - 5e-4])
        grid = np.linspace(edges[0], edges[1], HISTOGRAM_BINS + 1)

        def density(points: FloatArray, weights: FloatArray | None = None) -> list[float]:
            values = coordinates(compared.likelihood, points)[name]  # noqa: B023
            total = 1.0 / len(values) if weights is None else weights
            heights, _ = np.histogram(values, grid, weights=total * np.ones(len(values)))  # noqa: B023
            return [float(f"{h:.4g}") for h in heights / np.diff(grid)]  # noqa: B023

        found.append(
            {
                "coordinate": name,
                "edges": [float(f"{edge:.6g}") for edge in grid],
                "reference": density(compared.pooled, compared.weights),
                "nested": density(check.points, check.weights),
                "long": density(runs["long"][0].points),
                "full": [density(posterior.points) for posterior in runs["full"]],
            }
        )
    return found


def _versions() -> dict[str, str]:
    packages = ("hdprog", "dynesty", "numba", "emcee", "arviz", "numpy", "scipy")
    return {"python": platform.python_version()} | {name: version(name) for name in packages}


def read(case: Case) -> dict[str, Any] | None:
    """A case's result, if there is one of this state of the code."""
    file = RESULTS / f"{case.name}.json"
    found = json.loads(file.read_text("utf-8")) if file.exists() else None
    return found if found and found["code"] == state_of_code() else None


def main() -> None:
    """Run what is asked and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", choices=[case.name for case in CASES], help="this one, anew")
    parser.add_argument("--summary", action="store_true", help="only make the summary anew")
    asked = parser.parse_args()
    prepare_numerics()
    for case in CASES:
        wanted = case.name == asked.case if asked.case else read(case) is None
        if asked.summary or not wanted:
            continue
        print(f"{case.name} ...", flush=True)
        found = measured(case)
        text = json.dumps(rounded(found), indent=1)
        atomic_write_text(RESULTS / f"{case.name}.json", text + "\n")
        print(f"{case.name}: {found['processor_seconds']}", flush=True)
    files = [RESULTS / f"{case.name}.json" for case in CASES]
    results = [json.loads(file.read_text("utf-8")) for file in files if file.exists()]
    if not results:
        raise SystemExit(f"no results in {RESULTS}")
    words = in_words(results, state_of_code(), len(CASES))
    atomic_write_text(RESULTS / "summary.md", words)
    write_picture(results, PICTURE)
    print(words)


if __name__ == "__main__":
    main()
