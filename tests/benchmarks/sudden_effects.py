"""Are limits forecast rightly where an effect comes at once between two tests? Run off line.

    python -m tests.benchmarks.sudden_effects [--drives 8]

Wearing drives as in tests/benchmarks/growing_effects.py, but the play beside the drive model does
not grow: it is absent up to the second of eight tests or later, and of one size from one of the
next hours on, two tests at least before the last. Limit, forecast and scores are those of that
benchmark. Written to tests/benchmarks/results/sudden_effects.json.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.parallel import prepare_numerics
from tests.benchmarks.code_state import digest, imported_by
from tests.benchmarks.growing_effects import (
    HANGS_ON,
    TESTS,
    forecast,
    summarised,
    tested_at,
    write_drive,
)
from tests.independent.drives import WearingDrive
from tests.independent.simulator import FloatArray

RESULTS = Path(__file__).parent / "results" / "sudden_effects.json"
_EFFECT = "play"
_SEED = 53


def at_once(life: WearingDrive, rng: np.random.Generator) -> FloatArray:
    """Share of the effect's size along a life's hours: 0, then 1."""
    service = tested_at(float(life.hours[-1]))
    after = int(rng.integers(2, TESTS - 1))
    came = rng.uniform(service[after - 1], service[after])
    return np.asarray((life.hours >= came).astype(float))


def steps_called(out: Path) -> list[Any]:
    """Tests between which an effect came at once, as a run has them."""
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    return [one["between_tests"] for one in summary["trend"]["sudden_effects"]]


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=8)
    parser.add_argument("--file", type=Path, default=RESULTS)
    asked = parser.parse_args()
    prepare_numerics()
    drives = []
    with tempfile.TemporaryDirectory() as place:
        for number in range(asked.drives):
            folder, out = Path(place) / f"sudden-{number}", Path(place) / f"o-{number}"
            truth = write_drive(folder, _EFFECT, number, at_once, _SEED)
            found = forecast(folder, out, _EFFECT, truth)
            drives.append(found | {"called": steps_called(out)})
            print(json.dumps(drives[-1]), flush=True)
    results = {
        "command": f"python -m tests.benchmarks.sudden_effects --drives {asked.drives}",
        "code": digest(imported_by(*HANGS_ON)),
        "summary": summarised(drives, _EFFECT)
        | {"called": sum(bool(drive["called"]) for drive in drives)},
        "drives": drives,
    }
    atomic_write_text(asked.file, json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
