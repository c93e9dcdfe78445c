"""What do the tests of a drive tell together of an effect that all have in common?

    python -m tests.benchmarks.common_effects [--clean 40] [--each 8] [--tests 6]

Wearing drives of the simulator in tests/independent, which shares no code with hdprog: without an
effect, and with one that is the same in every test, from hardly to clearly seen in a single one.
The search is given all effects. Written to tests/benchmarks/results/common_effects.json: how many
drives get what, and how many would have got the right name where every test has parameters of its
own, from the same fits.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.data.drive_folder import read_drive_folder, read_test_loop
from hdprog.discovery.pooling import THRESHOLD, pooled
from hdprog.discovery.search import Traced
from hdprog.discovery.sharing import gain_of_steps
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.priors import RecordScales
from hdprog.parallel import prepare_numerics
from hdprog.tests_of_drive import trace_tests
from tests.benchmarks.code_state import digest, imported_by
from tests.independent.drives import LAWS
from tests.make_undeclared_effect import CASES, write_case

RESULTS = Path(__file__).parent / "results" / "common_effects.json"
FIRST = 1000  # number of the first drive, far from the shipped ones
AMPLITUDES = {
    "creep": (5e-6, 1e-5, 2e-5),
    "kinematic_error": (4e-6, 6e-6, 9e-6),
    "coulomb_friction": (3e-6, 6e-6, 1.2e-5),
}
"""In rad; a reading's noise is 1e-5 rad."""


@dataclass(frozen=True)
class Found:
    """What was found on a drive.

    Attributes
    ----------
    names : ids of effects in any test
    unknown : whether a test got an empirical term
    alone : highest gain of the effect in a single test; of the best effect where there is none
    own, together : gain over all tests, with parameters of their own, and as the search counts it
    """

    names: tuple[str, ...]
    unknown: bool
    alone: float
    own: float
    together: float


def found_on(drive: tuple[int, str | None, float], tests: int) -> Found:
    """Draw a drive, search what it lacks.

    Parameters
    ----------
    drive : number, effect and its amplitude in rad
    tests : how many
    """
    number, effect, amplitude = drive
    prepare_numerics()
    amplitudes = {} if effect is None else {effect: amplitude}
    case = replace(CASES[0], amplitudes=amplitudes, law=LAWS[number % len(LAWS)])
    with tempfile.TemporaryDirectory() as place:
        write_case(Path(place), case, FIRST + number, tests)
        folder = read_drive_folder(Path(place))
        loops = [read_test_loop(folder, test) for test in folder.tests]
    scales = RecordScales.of(loops[0].torque, loops[0].angle)
    prior, _ = prior_of_drive(folder.drive, scales)
    seeds = np.random.SeedSequence(number).spawn(tests)
    return _told(trace_tests(folder, loops, prior, seeds, None), effect)


def _told(traced: Sequence[Traced], effect: str | None) -> Found:
    steps = [one.steps[0] for one in traced]
    gains = {name: gain_of_steps(name, steps)[0] for step in steps for name in step.models}
    name = max(gains, key=lambda one: gains[one]) if effect is None else effect
    own = [step.gains[name] for step in steps]
    return Found(
        tuple(sorted({one for record in traced for one in record.final.ids})),
        any(record.final.term is not None for record in traced),
        max(own),
        pooled(own),
        gains[name],
    )


def _summed_up(effect: str | None, amplitude: float, found: Sequence[Found]) -> dict[str, Any]:
    """One line of the results."""
    line: dict[str, Any] = {"effect": effect, "amplitude_rad": amplitude, "drives": len(found)}
    if effect is None:
        line["found_nothing"] = sum(not (one.names or one.unknown) for one in found)
        line["highest_gain"] = round(max(one.together for one in found), 1)
        return line
    return line | {
        "only_the_right_name": sum(one.names == (effect,) and not one.unknown for one in found),
        "right_name": sum(effect in one.names for one in found),
        "unknown": sum(one.unknown for one in found),
        "other_names": sorted({name for one in found for name in one.names} - {effect}),
        "above_threshold_in_a_single_test": sum(one.alone > THRESHOLD for one in found),
        "above_threshold_with_own_parameters": sum(one.own > THRESHOLD for one in found),
        "above_threshold_together": sum(one.together > THRESHOLD for one in found),
    }


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clean", type=int, default=40)
    parser.add_argument("--each", type=int, default=8)
    parser.add_argument("--tests", type=int, default=6)
    asked = parser.parse_args()
    cells: list[tuple[str | None, float, int]] = [(None, 0.0, asked.clean)]
    for effect, amplitudes in AMPLITUDES.items():
        cells += [(effect, amplitude, asked.each) for amplitude in amplitudes]
    lines = []
    with ProcessPoolExecutor(2) as executor:
        for effect, amplitude, count in cells:
            drives = [(number, effect, amplitude) for number in range(count)]
            found = list(executor.map(partial(found_on, tests=asked.tests), drives))
            lines.append(_summed_up(effect, amplitude, found))
            print(json.dumps(lines[-1]), flush=True)
    results = {
        "command": "python -m tests.benchmarks.common_effects "
        f"--clean {asked.clean} --each {asked.each} --tests {asked.tests}",
        "code": digest(imported_by("hdprog.tests_of_drive")),
        "threshold": THRESHOLD,
        "drives": lines,
    }
    atomic_write_text(RESULTS, json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
