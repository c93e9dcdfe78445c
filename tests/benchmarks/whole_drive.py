"""How long does a drive of ten tests take, from the command to the report? Run off line.

    python -m tests.benchmarks.whole_drive [--rounds 2]

`hdprog run`, as a command of its own: on the shipped wearing drive, and on drives
of ten tests of the simulator in tests/independent with effects that nobody declared. Machines
differ and have their days: before each command a fixed piece of arithmetic runs in two processes
at once; its seconds are noted beside the command's, and runs are compared by both. Written to
tests/benchmarks/results/whole_drive.json.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.parallel import cores, prepare_numerics
from tests.make_undeclared_effect import CASES, write_case

RESULTS = Path(__file__).parent / "results" / "whole_drive.json"
WEARING = Path(__file__).parents[2] / "datasets" / "wearing-csf-25-80"
TESTS = 10
COMMAND = [sys.executable, "-c", "from hdprog.cli import main; main()"]
EXIT_CODES = (0, 4)  # fits that did not converge take their time as well


def clock(seed: int) -> float:
    """Seconds of a fixed piece of arithmetic of the kinds that a fit is made of.

    Mostly products of matrices and passes over arrays of some hundred kB, with few exponentials:
    these alone differ fivefold between processors, by how wide their vector instructions are.
    """
    rng = np.random.default_rng(seed)
    torque, draws = rng.uniform(-60.0, 60.0, (30, 300)), rng.uniform(1.0, 2.0, (96, 30))
    started = time.perf_counter()
    for _ in range(8_000):
        angle = draws @ torque
        np.maximum(angle, draws[:, :1], out=angle)
        angle -= torque[0] * draws[:, 1:2]
        np.exp(draws).sum(axis=1)
        np.einsum("ij,ij->i", angle, angle)
    return time.perf_counter() - started


def machine_seconds() -> float:
    """The clock's seconds while another one runs beside it."""
    with ProcessPoolExecutor(2) as executor:
        return float(np.mean(list(executor.map(clock, range(2)))))


def timed(drive: Path, out: Path) -> dict[str, Any]:
    """Run one drive and say how long it took."""
    machine = machine_seconds()
    started = time.perf_counter()
    command = [*COMMAND, "run", str(drive), "--out", str(out), "--seed", "1"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in EXIT_CODES or not (out / "report.html").is_file():
        raise RuntimeError(f"hdprog run {drive} ended with {done.returncode}: {done.stderr}")
    return {
        "drive": drive.name,
        "seconds": round(time.perf_counter() - started, 1),
        "machine_s": round(machine, 2),
        "exit_code": done.returncode,
    }


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=2)
    asked = parser.parse_args()
    prepare_numerics()
    runs = []
    with tempfile.TemporaryDirectory() as place:
        drives = [WEARING]
        for number, case in enumerate(CASES):
            drives.append(Path(place) / case.name)
            write_case(drives[-1], case, number, TESTS)
        for count in range(asked.rounds):
            for drive in drives:
                runs.append(timed(drive, Path(place) / f"out-{count}-{drive.name}"))
                print(json.dumps(runs[-1]), flush=True)
    results = {
        "command": f"python -m tests.benchmarks.whole_drive --rounds {asked.rounds}",
        "cores": cores(),
        "longest_s": max(run["seconds"] for run in runs),
        "runs": runs,
    }
    atomic_write_text(RESULTS, json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
