"""Compare all models on records: new, worn, with an effect, with a moving output, measured.

    python -m tests.benchmarks.models.run [--data DIR] [--only NAME] [--quick]
    python -m tests.benchmarks.models.run --table

DIR holds the folders torsion-spring and cycloidal-torque-ramps, which are no part of the project;
without it the records that the project makes are run. Writes results/comparisons.json beside this
file (entries of records that were not run are kept) and the tables of reports/guide/models.md.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hdprog.comparing import compare
from hdprog.comparison.results import Comparison
from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.reporting.comparison_words import stiffness_at_end
from tests.benchmarks.models.records import SEED, Record, made, measured
from tests.benchmarks.models.summary import updated

RESULTS = Path(__file__).parent / "results"
PAGE = Path(__file__).parents[3] / "reports" / "guide" / "models.md"


def main() -> None:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--data", type=Path, help="folder of the measured records")
    parser.add_argument("--only", help="run records whose name holds this")
    parser.add_argument("--quick", action="store_true", help="fewer draws")
    parser.add_argument("--table", action="store_true", help="write the tables anew, run nothing")
    asked = parser.parse_args()
    path = RESULTS / "comparisons.json"
    found: dict[str, Any] = json.loads(path.read_text("utf-8")) if path.exists() else {}
    if not asked.table:
        for record in _records(asked.data):
            if asked.only is not None and asked.only not in record.name:
                continue
            result = compare(record.loop, record.drive, seed=SEED, quick=asked.quick).result
            found[record.name] = _entry(record, result)
            path.write_text(json.dumps(found, indent=1, allow_nan=False) + "\n", "utf-8")
            print(record.name, f"{result.seconds['compare']:.0f} s", flush=True)
    PAGE.write_text(updated(PAGE.read_text("utf-8"), found), "utf-8")


def _records(data: Path | None) -> Iterator[Record]:
    yield from made()
    if data is not None:
        yield from measured(data)


def _entry(record: Record, result: Comparison) -> dict[str, Any]:
    return {
        "made": record.made,
        "sha256": result.loop.sha256,
        "samples": len(result.loop),
        "noise_floor_rad": result.noise_floor_rad,
        "amplitude_Nm": result.amplitude,
        "width_at_Nm": result.width_torque,
        "quick": result.provenance.quick,
        "seconds": round(result.seconds["compare"], 1),
        "left_out": {one.id: one.why for one in result.left_out},
        "models": [
            {
                "id": one.id,
                "words": one.words,
                "converged": one.converged,
                "rmse_rad": one.errors.rmse_rad,
                "heldout_rmse_rad": one.errors.heldout_rmse_rad,
                "elpd_difference": one.evidence.difference,
                "elpd_difference_se": one.evidence.difference_se,
                "heldout_elpd_difference": one.evidence.heldout_difference,
                "heldout_elpd_difference_se": one.evidence.heldout_difference_se,
                "level": one.evidence.level_with_the_best,
                "stacking_weight": one.evidence.weight,
                "width_arcmin": ARCMIN_PER_RAD * one.width[0.5],
                "stiffness_Nm_per_rad": None if one.stiffness is None else stiffness_at_end(one),
                "noise": one.noise_model,
                "seconds": round(one.seconds, 1),
            }
            for one in result.models
        ],
    }


if __name__ == "__main__":
    main()
