"""Coverage of loop posteriors on loops of the independent simulator.

    python -m tests.benchmarks.loop_coverage [--loops 100] [--workers 2]

Loops of every kind (one- and two-sided, several rates, several cycles, minor loops), drawn by
`tests.independent.loops`, which shares no code with hdprog, are fitted with the shipped prior of a
CSF-25-80. Written to tests/benchmarks/results/loop_coverage.json: the share of true parameters
inside the 90 % and 50 % intervals, by parameter and by kind of loop, convergence and effort.
"""

from __future__ import annotations

import argparse
import json
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.prior_file import read_prior_file
from hdprog.parallel import prepare_numerics
from hdprog.physics.parameters import NAMES
from tests.independent.loops import KINDS, random_loop

RESULTS = Path(__file__).parent / "results" / "loop_coverage.json"
SEED = 31


@dataclass(frozen=True)
class Fitted:
    """One loop: share of the posterior below each true parameter, and how the fit went."""

    kind: str
    below: list[float]
    converged: bool
    correlated: bool
    evaluations: float
    seconds: float


def fitted(number: int) -> Fitted:
    """Draw and fit one loop."""
    rng = np.random.default_rng([SEED, number])
    kind = KINDS[number % len(KINDS)]
    record = random_loop(rng, kind)
    drive = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
    prior = read_prior_file("csf-25-80").prior(None)
    loop = Loop(torque=record.torque, angle=record.angle, time=record.time)
    started = time.perf_counter()
    posterior = fit_loop(loop, drive, rng, prior=prior)
    truth = record.truth["parameters"]
    return Fitted(
        kind,
        [float((posterior.parameters[name] < truth[name]).mean()) for name in NAMES],
        posterior.converged,
        posterior.likelihood.noise.whitening is not None,
        posterior.sampling["evaluations"],
        time.perf_counter() - started,
    )


def held(below: np.ndarray, tail: float) -> np.ndarray:
    """Whether the truth lies inside the central interval that leaves `tail` on each side."""
    return (below > tail) & (below < 1 - tail)


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--loops", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    with ProcessPoolExecutor(asked.workers, initializer=prepare_numerics) as executor:
        found = list(executor.map(fitted, range(asked.loops)))
    below = np.array([one.below for one in found])
    kinds = np.array([one.kind for one in found])
    results = {
        "loops": len(found),
        "seed": SEED,
        "coverage_90": round(float(held(below, 0.05).mean()), 3),
        "coverage_50": round(float(held(below, 0.25).mean()), 3),
        "coverage_90_by_parameter": dict(
            zip(NAMES, held(below, 0.05).mean(axis=0).round(3).tolist(), strict=True)
        ),
        "coverage_90_by_kind": {
            kind: round(float(held(below[kinds == kind], 0.05).mean()), 3) for kind in KINDS
        },
        "converged": round(float(np.mean([one.converged for one in found])), 3),
        "correlated_noise_found": round(float(np.mean([one.correlated for one in found])), 3),
        "median_evaluations": float(np.median([one.evaluations for one in found])),
        "median_seconds_beside_another_fit": round(
            float(np.median([one.seconds for one in found])), 2
        ),
    }
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
