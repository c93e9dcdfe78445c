"""Whether a drive's figures are right where an effect was found and added.

    python -m tests.benchmarks.explained_coverage --sizes 1,2,4 [--per-cell 1] [--workers 2]

Loops with one effect of the independent simulator, which shares no code with hdprog and draws the
effects in other shapes, are explained blind with the prior of a CSF-25-80. The figures of the drive
alone, its effects apart, are compared with those that the simulator has for its parameters: by the
drive model without effects, and by the model that the search ended with. Every finished loop is a
line of results/explained_coverage.jsonl, so that a run that was broken off goes on;
results/explained_coverage.json is made anew from all of them.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.config import Drive
from hdprog.discovery.explain import sample_base, sample_final
from hdprog.discovery.search import trace
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.sampling_plan import QUICK
from hdprog.parallel import prepare_numerics
from hdprog.physics.figures import FigureRequest
from tests.benchmarks.code_state import digest, imported_by
from tests.benchmarks.effects.loops import LISTED, Case, NotDrawable, draw
from tests.independent.effects import EFFECTS
from tests.independent.loops import random_loop
from tests.independent.simulator import DriveParameters, true_figures

RESULTS = Path(__file__).parent / "results"
LINES, SUMMARY = RESULTS / "explained_coverage.jsonl", RESULTS / "explained_coverage.json"
COMMAND = "python -m tests.benchmarks.explained_coverage"
FIGURES = (
    FigureRequest("hysteresis_width_arcmin"),
    FigureRequest("hysteresis_loss_J"),
    FigureRequest("lost_motion_arcmin"),
    FigureRequest("secant_stiffness_Nm_per_rad", 14.0),
    FigureRequest("secant_stiffness_Nm_per_rad", 63.0),
)
DRIVE = replace(
    Drive.default(), model="CSF-25-80", ratio=80.0, rated_torque=63.0, alpha_declared=True
)
_STREAM = 0  # of `Case.rng`, by which `draw` makes its record


def state_of_code() -> str:
    """Digest of the sources that the outcome hangs on."""
    return digest(
        imported_by(
            "hdprog.discovery.explain",
            "hdprog.discovery.search",
            "tests.benchmarks.effects.loops",
            "tests.independent.effects",
        )
    )


def measured(case: Case, index: int, code: str) -> dict[str, Any]:
    """Explain one loop; its figures with and without what was added, and the true ones."""
    line: dict[str, Any] = {"case": case.name, "index": index, "code": code}
    try:
        drawn = draw(case, index)
    except NotDrawable as reason:
        return line | {"not_drawable": str(reason)}
    # The same draws again: what the fit must not see is in this record alone.
    record = random_loop(case.rng(index, _STREAM, drawn.rejected), drawn.kind, effects=drawn.sizes)
    truth = record.truth["parameters"]
    assert isinstance(truth, dict)
    exact = true_figures(DriveParameters(**truth), reference_torque=63.0, secant_torque=14.0)
    exact |= true_figures(DriveParameters(**truth), reference_torque=63.0, secant_torque=63.0)
    prior, rng = read_prior_file("csf-25-80").prior(None), case.fit_rng(index)
    started = time.perf_counter()
    prepared = prepare(drawn.loop, DRIVE, rng, prior=prior)
    traced = trace([prepared], [np.random.SeedSequence(int(rng.integers(2**32)))])[0]
    after = sample_final(traced, rng, QUICK)
    before = sample_base(traced, rng) or after
    assert case.effect is not None
    return line | {
        "kind": drawn.kind,
        "reached": drawn.reached[case.effect],
        "names": list(traced.final.ids),
        "right": EFFECTS[case.effect].identifier in traced.final.ids,
        "curve": traced.final.term is not None,
        "converged": after.converged,
        "pareto_k": after.sampling.get("pareto_k"),
        "seconds": time.perf_counter() - started,
        "figures": {
            request.key: {
                "true": exact[request.key],
                "before": _said(before, request, exact[request.key]),
                "after": _said(after, request, exact[request.key]),
            }
            for request in FIGURES
        },
    }


def _said(posterior: Posterior, request: FigureRequest, exact: float) -> dict[str, float]:
    """Median and standard deviation of a figure, and the share of its draws below the truth."""
    draws = posterior.figures((request,))[request.key]
    return {
        "median": float(np.median(draws)),
        "sd": float(np.std(draws)),
        "below": float(np.mean(draws < exact)),
    }


def summary(lines: list[dict[str, Any]]) -> dict[str, Any]:
    """Coverage and errors of the loops to which something was added, and of the others."""
    fitted = [line for line in lines if "figures" in line]
    added = [line for line in fitted if line["names"] or line["curve"]]
    sizes = sorted({_size(line) for line in lines})
    return {
        "command": f"{COMMAND} --sizes {','.join(f'{size:g}' for size in sizes)}",
        "state_of_code": sorted({line["code"] for line in lines}),
        "loops": len(lines),
        "not_drawable": len(lines) - len(fitted),
        "not_converged": sum(not line["converged"] for line in fitted),
        "nothing_added": _group([line for line in fitted if line not in added]),
        "added": _group(added),
        "added_by_name": {
            name: _group([line for line in added if line["right"] == right])
            for name, right in (("right", True), ("wrong", False))
        },
        "added_by_figure": {one.key: _group(added, (one,)) for one in FIGURES},
        "added_by_size": {
            f"{size:g}": _group([line for line in added if _size(line) == size]) for size in sizes
        },
        "added_by_effect": {
            name: _group([line for line in added if line["case"].split("@")[0] == name])
            for name in LISTED
        },
    }


def _size(line: dict[str, Any]) -> float:
    return float(line["case"].split("@")[1])


def _group(
    lines: list[dict[str, Any]], requests: Sequence[FigureRequest] = FIGURES
) -> dict[str, Any]:
    found: dict[str, Any] = {"loops": len(lines)}
    for when in ("before", "after") if lines else ():
        values = [line["figures"][one.key] for line in lines for one in requests]
        found[when] = _judged([(value["true"], value[when]) for value in values])
    return found


def _judged(pairs: Iterable[tuple[float, dict[str, float]]]) -> dict[str, float]:
    """Coverage, median size of the error in percent, and of the error over its deviation."""
    below, off, scaled = [], [], []
    for exact, said in pairs:
        below.append(said["below"])
        off.append(abs(said["median"] / exact - 1.0))
        scaled.append(abs(said["median"] - exact) / said["sd"])
    inside = np.abs(np.asarray(below) - 0.5)
    return {
        "coverage_90": round(float(np.mean(inside < 0.45)), 3),
        "coverage_50": round(float(np.mean(inside < 0.25)), 3),
        "median_error_percent": round(100.0 * float(np.median(off)), 2),
        "median_error_over_sd": round(float(np.median(scaled)), 2),
    }


def read_lines() -> list[dict[str, Any]]:
    """What was measured so far."""
    if not LINES.exists():
        return []
    return [json.loads(line) for line in LINES.read_text("utf-8").splitlines()]


def main() -> None:
    """Measure what is asked for and not measured yet, and write the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", default="1,2,4", help="over the noise, separated by commas")
    parser.add_argument("--per-cell", type=int, default=1, help="loops of every effect and size")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    code = state_of_code()
    done = {(line["case"], line["index"]) for line in read_lines()}
    wanted = [
        (Case(f"{name}@{float(size):g}"), index)
        for index in range(asked.per_cell)
        for size in asked.sizes.split(",")
        for name in LISTED
    ]
    left = [(case, index) for case, index in wanted if (case.name, index) not in done]
    RESULTS.mkdir(exist_ok=True)
    with ProcessPoolExecutor(asked.workers, initializer=prepare_numerics) as executor:
        running = [executor.submit(measured, case, index, code) for case, index in left]
        for finished in as_completed(running):
            with LINES.open("a", encoding="utf-8") as file:
                file.write(json.dumps(finished.result()) + "\n")
    result = summary(read_lines())
    atomic_write_text(SUMMARY, json.dumps(result, indent=1) + "\n")
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
