"""How often is a fit said to miss what a record shows, where it does and where it does not?

    python -m tests.benchmarks.read_off [--clean 90] [--per-effect 3] [--workers 2]

Loops of the independent simulator, which shares no code with hdprog: without an effect (white,
correlated and stepped noise in turn) and with one effect at four times the noise, listed or not.
All are fitted with the drive model alone (quick plan), and figures are read off record and fit. A
loop with an effect stands for a drive that nobody explained. Written to
tests/benchmarks/results/read_off.json: of loops without an effect, how many readings are said to
differ, which are false alarms, and how far the gaps are from what chance makes of them; of loops
with one, how many are said to differ by the size of the gap.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.inference.against_record import against_record, spread_of_gap
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.sampling_plan import QUICK
from hdprog.parallel import prepare_numerics
from tests.benchmarks.code_state import digest, imported_by
from tests.benchmarks.effects.loops import LISTED, UNLISTED, Case, NotDrawable, draw
from tests.benchmarks.explained_coverage import DRIVE, FIGURES

RESULTS = Path(__file__).parent / "results" / "read_off.json"
NOISE = ("clean", "correlated", "stepped")
SIZE = 4
GAPS = (0.0, 0.03, 0.1, 0.3, 10.0)


@dataclass(frozen=True)
class Found:
    """One figure of one loop.

    Attributes
    ----------
    case, quantity : of the loop and the figure
    deviations : the record's reading minus the fit's, over what chance makes of it
    gap : the same over the larger one of both
    differs : what is said
    """

    case: str
    quantity: str
    deviations: float
    gap: float
    differs: bool


def measured(work: tuple[str, int]) -> list[Found]:
    """Fit one loop with the drive model alone and read its figures; none of a one-sided loop."""
    case, index = Case(work[0]), work[1]
    try:
        drawn = draw(case, index)
    except NotDrawable:
        return []
    prior = read_prior_file("csf-25-80").prior(None)
    posterior = fit_loop(drawn.loop, DRIVE, case.fit_rng(index), prior=prior, plan=QUICK)
    found = []
    for key, read in against_record(posterior, FIGURES).items():
        off = read.record - read.fit[0.50]
        larger = max(abs(read.record), abs(read.fit[0.50]))
        deviations = off / spread_of_gap(read.record_sd, read.fit)
        found.append(Found(case.name, key, deviations, off / larger, read.differs))
    return found


def summary(found: list[Found]) -> dict[str, Any]:
    """False alarms without an effect, and what is said beside one."""
    without = [one for one in found if one.case in NOISE]
    beside = [one for one in found if one.case not in NOISE]
    return {
        "state_of_code": digest(
            imported_by("hdprog.inference.against_record", "hdprog.inference.fit_loop")
        ),
        "without_an_effect": {
            "readings": len(without),
            "differ": sum(one.differs for one in without),
            "deviations_sd": _spread(without),
            "deviations_largest": round(max(abs(one.deviations) for one in without), 2),
            "by_noise": {
                name: _spread([one for one in without if one.case == name]) for name in NOISE
            },
            "by_quantity": {
                key.key: _spread([one for one in without if one.quantity == key.key])
                for key in FIGURES
            },
        },
        "with_an_effect": {
            "readings": len(beside),
            "differ_by_gap": {
                f"{low:.0%} to {high:.0%}": _said(
                    [one for one in beside if low <= abs(one.gap) < high]
                )
                for low, high in pairwise(GAPS)
            },
        },
    }


def _spread(found: Iterable[Found]) -> float:
    """Root of the mean square of the deviations: 1 where they are the noise's and the fit's."""
    return round(float(np.sqrt(np.mean([one.deviations**2 for one in found]))), 2)


def _said(found: list[Found]) -> dict[str, int]:
    return {"readings": len(found), "differ": sum(one.differs for one in found)}


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clean", type=int, default=90)
    parser.add_argument("--per-effect", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    work = [(NOISE[index % len(NOISE)], index) for index in range(asked.clean)]
    effects = (*LISTED, *UNLISTED)
    work += [(f"{name}@{SIZE}", index) for index in range(asked.per_effect) for name in effects]
    with ProcessPoolExecutor(asked.workers, initializer=prepare_numerics) as executor:
        found = [one for each in executor.map(measured, work) for one in each]
    results = summary(found)
    atomic_write_text(RESULTS, json.dumps(results, indent=1) + "\n")
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
