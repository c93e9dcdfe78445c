"""How much faster are many loops fitted on two cores than on one? Run off line.

    python -m tests.benchmarks.two_cores [--copies 2] [--rounds 3]

The tests of a shipped drive, each some times with other seeds, are fitted as `hdprog run` fits
them, by one process and by two, in turns, so that a busy machine slows both alike. Written to
tests/benchmarks/results/two_cores.json: seconds of each round, the machine's load before it, and
the median of the ratios. Ratios count only where the load was near 0. That the draws do not depend
on the number of workers is checked on the way.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.data.drive_folder import read_drive_folder, read_test_loop
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.priors import RecordScales
from hdprog.inference.sampling_plan import FULL
from hdprog.parallel import cores, prepare_numerics, process_executor
from hdprog.tests_of_drive import FittedTest, fit_tests

RESULTS = Path(__file__).parent / "results" / "two_cores.json"
DRIVE = Path(__file__).parents[2] / "datasets" / "wearing-csf-25-80"
SEED = 17


def timed(copies: int, workers: int) -> tuple[float, list[FittedTest]]:
    """Seconds to fit all tests, and the fits."""
    folder = read_drive_folder(DRIVE)
    folder = replace(folder, tests=folder.tests * copies)
    loops = [read_test_loop(folder, test) for test in folder.tests]
    prior, _ = prior_of_drive(folder.drive, RecordScales.of(loops[0].torque, loops[0].angle))
    seeds = np.random.SeedSequence(SEED).spawn(len(loops))
    started = time.perf_counter()
    with process_executor(workers) as executor:
        fitted = fit_tests(folder, loops, prior, seeds, FULL, executor)
    return time.perf_counter() - started, fitted


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--copies", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    asked = parser.parse_args()
    prepare_numerics()
    rounds = []
    for _ in range(asked.rounds):
        load = os.getloadavg()[0]
        one, alone = timed(asked.copies, 1)
        two, beside = timed(asked.copies, 2)
        for mine, other in zip(alone, beside, strict=True):
            np.testing.assert_array_equal(mine.posterior.chains, other.posterior.chains)
        rounds.append({"load": round(load, 2), "one_s": round(one, 2), "two_s": round(two, 2)})
    ratio = float(np.median([each["one_s"] / each["two_s"] for each in rounds]))
    results = {
        "command": f"python -m tests.benchmarks.two_cores --copies {asked.copies}",
        "cores": cores(),
        "loops": len(alone),
        "rounds": rounds,
        "times_faster": round(ratio, 2),
    }
    RESULTS.parent.mkdir(exist_ok=True)
    atomic_write_text(RESULTS, json.dumps(results, indent=1) + "\n")
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
