"""hdprog's sampler beside those of other packages, on one core.

    python -m tests.benchmarks.samplers.run
    python -m tests.benchmarks.samplers.run --summary
    python -m tests.benchmarks.samplers.run --samplers hdprog --again

The peers need an environment of their own, see requirements.txt. First the log density that peers
sample is compared with hdprog's on every posterior: where the two differ nothing is measured. Then
the samplers take turns on each posterior. Every measurement is a line of results/samplers.jsonl, so
that a run that was broken off goes on where it ended. Then results/summary.md and the picture
reports/guide/samplers.png are made anew. The last line of a posterior and sampler counts; the
summary says where lines come from several states of the code.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

import hdprog
from hdprog.atomic import atomic_write_text
from hdprog.inference.lazy_arviz import arviz
from hdprog.parallel import prepare_numerics
from tests.benchmarks.code_state import digest, imported_by
from tests.benchmarks.rounded import rounded
from tests.benchmarks.samplers import Outcome, read_outcomes
from tests.benchmarks.samplers.ensemble import zeus_slices
from tests.benchmarks.samplers.equality import TOLERANCE, compare
from tests.benchmarks.samplers.log_density import peer
from tests.benchmarks.samplers.measuring import Found
from tests.benchmarks.samplers.nested import dynesty_nested
from tests.benchmarks.samplers.nuts import (
    blackjax_nuts,
    numpyro_nuts,
    numpyro_nuts_unconstrained,
    nutpie_nuts,
    settle_jax,
)
from tests.benchmarks.samplers.own import hdprog as hdprog_full_plan
from tests.benchmarks.samplers.own import preparation_evaluations
from tests.benchmarks.samplers.picture import write_picture
from tests.benchmarks.samplers.posteriors import POSTERIORS, Target, prepared_target
from tests.benchmarks.samplers.summary import OWN, in_words, summary

RESULTS = Path(__file__).parent / "results"
PICTURE = Path(__file__).parents[3] / "reports" / "guide" / "samplers.png"
BOUND = 60.0
"""Processor seconds, compilation aside, after which a sampler is stopped."""
SAMPLERS: dict[str, Callable[[Target, float], Found]] = {
    OWN: lambda target, bound: hdprog_full_plan(target),
    "NumPyro NUTS": numpyro_nuts,
    "BlackJAX NUTS": blackjax_nuts,
    "nutpie": nutpie_nuts,
    "zeus": zeus_slices,
    "dynesty": dynesty_nested,
    "NumPyro NUTS, unconstrained": numpyro_nuts_unconstrained,
}
UNLESS_ASKED = ("NumPyro NUTS, unconstrained",)
"""Left out of a run unless named: it shows what ridge coordinates are worth, at length."""
_PACKAGES = ("numpy", "scipy", "emcee", "arviz", "jax", "jaxlib", "numba")
_PEERS = ("numpyro", "blackjax", "nutpie", "zeus-mcmc", "dynesty")
_ONE_THREAD = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"


@lru_cache(maxsize=1)
def state_of_code() -> str:
    """Digest of the sources that a measurement hangs on."""
    return digest(imported_by("hdprog.inference.fit_loop"))


def on_one_core(core: int | None) -> None:
    """Bind this process, and what the peers start in it, to one core."""
    prepare_numerics()
    os.environ.setdefault("XLA_FLAGS", _ONE_THREAD)
    os.environ.setdefault("NUMBA_NUM_THREADS", "1")
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0)) if core is None else core})


def measured(target: Target, sampler: str, bound: float) -> Outcome:
    """Let one sampler draw from one posterior."""
    outcome = Outcome(
        target.index,
        sampler,
        state_of_code(),
        kind=target.drawn.kind,
        blocks=target.likelihood.blocks,
        stretches=int(target.likelihood.reduced.path.starts.size),
    )
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            found = SAMPLERS[sampler](target, bound)
    except Exception as error:  # one sampler that fails must not end the run; it is counted
        outcome.status, outcome.reason = "failed", f"{type(error).__name__}: {error}"[:300]
        return outcome
    flat = found.points.reshape(-1, found.points.shape[-1])
    mean = np.average(flat, axis=0, weights=found.weights)
    variance = np.average((flat - mean) ** 2, axis=0, weights=found.weights)
    outcome.reached = found.effective.enough
    outcome.ess_bulk, outcome.ess_tail = found.effective.bulk, found.effective.tail
    outcome.rhat = found.effective.rhat
    outcome.chains, outcome.draws = found.points.shape[:2]
    outcome.processor_seconds, outcome.wall_seconds = found.watch.processor, found.watch.wall
    outcome.evaluations, outcome.gradients = found.evaluations, found.gradients
    outcome.mean, outcome.sd = mean.tolist(), np.sqrt(variance).tolist()
    outcome.converged = found.converged
    if sampler == OWN:
        outcome.preparation_evaluations = preparation_evaluations(target.index)
    return outcome


def check(targets: Sequence[Target], file: Path) -> None:
    """Compare the densities and write what was found.

    Raises SystemExit where they differ.
    """
    found = [compare(target) for target in targets]
    file.parent.mkdir(parents=True, exist_ok=True)
    atomic_write_text(file, json.dumps([one.as_dict() for one in found], indent=1) + "\n")
    worst = max(one.deviation for one in found)
    print(f"densities equal to {worst:.1e} on {len(found)} posteriors")
    if not all(one.holds for one in found):
        wrong = [one.index for one in found if not one.holds]
        raise SystemExit(
            f"the peers' log density is not hdprog's on posteriors {wrong} (largest deviation "
            f"{worst:.1e}, at most {TOLERANCE:g} is allowed, or another support): log_density.py "
            "must follow the model before anything is compared"
        )


def run(
    count: int, samplers: Sequence[str], folder: Path, bound: float, *, again: bool = False
) -> None:
    """Measure what the file does not hold yet, or all of it again, and append it."""
    file = folder / "samplers.jsonl"
    done = {(one.index, one.sampler) for one in read_outcomes(file) if one.status != "failed"}
    done = set() if again else done
    print(f"one core, bound {bound:g} s; imports and what a package does once count for nobody")
    arviz()
    peer("emcee")
    settle_jax()
    targets = [prepared_target(index)[0] for index in range(count)]
    check(targets, folder / "equality.json")
    with file.open("a", encoding="utf-8") as stream:
        if file.stat().st_size and not file.read_bytes().endswith(b"\n"):  # was broken off
            stream.write("\n")
        for target in targets:
            for sampler in samplers:
                if (target.index, sampler) in done:
                    continue
                started = time.perf_counter()
                one = measured(target, sampler, bound)
                stream.write(json.dumps(rounded(asdict(one), 6)) + "\n")
                stream.flush()
                print(f"{one.words} [{time.perf_counter() - started:.0f} s]", flush=True)


def circumstances(bound: float) -> dict[str, Any]:
    """Versions, date and machine of a run."""
    versions = {"Python": platform.python_version(), "hdprog": hdprog.__version__}
    for package in (*_PACKAGES, *_PEERS):
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = "not installed"
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "command": "OMP_NUM_THREADS=1 python -m tests.benchmarks.samplers.run",
        "processor": _processor(),
        "bound": bound,
        "versions": versions,
    }


def _processor() -> str:
    """Name of the processor, where the system tells."""
    told = Path("/proc/cpuinfo")
    for line in told.read_text("utf-8").splitlines() if told.exists() else ():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()


def main() -> None:
    """Run what is asked and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--posteriors", type=int, default=POSTERIORS, metavar="N")
    parser.add_argument("--samplers", nargs="+", choices=list(SAMPLERS))
    parser.add_argument("--bound", type=float, default=BOUND, help="processor seconds of each")
    parser.add_argument("--again", action="store_true", help="measure what the file holds too")
    parser.add_argument("--core", type=int, help="number of the core to run on")
    parser.add_argument("--folder", type=Path, default=RESULTS)
    parser.add_argument("--picture", type=Path, default=PICTURE)
    parser.add_argument("--summary", action="store_true", help="only make the summary anew")
    asked = parser.parse_args()
    told = asked.folder / "circumstances.json"
    if not asked.summary:
        if "jax" in sys.modules:
            raise SystemExit("JAX is loaded already: it takes its threads before they are set")
        on_one_core(asked.core)
        usual = [name for name in SAMPLERS if name not in UNLESS_ASKED]
        named = asked.samplers or usual
        run(asked.posteriors, named, asked.folder, asked.bound, again=asked.again)
        atomic_write_text(told, json.dumps(circumstances(asked.bound), indent=1) + "\n")
    outcomes = read_outcomes(asked.folder / "samplers.jsonl")
    if not any(one.status == "measured" and one.sampler == OWN for one in outcomes):
        raise SystemExit(f"no measurement of {OWN} in {asked.folder / 'samplers.jsonl'}")
    fused = asked.folder / "fused.json"
    result = summary(
        outcomes,
        [name for name in SAMPLERS if any(one.sampler == name for one in outcomes)],
        json.loads(told.read_text("utf-8")) if told.exists() else circumstances(asked.bound),
        json.loads((asked.folder / "equality.json").read_text("utf-8")),
        json.loads(fused.read_text("utf-8")) if fused.exists() else None,
    )
    atomic_write_text(asked.folder / "summary.md", in_words(result))
    write_picture(result, asked.picture)
    print(in_words(result))


if __name__ == "__main__":
    main()
