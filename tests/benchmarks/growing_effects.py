"""Are limits forecast rightly where wear brings an effect that the drive model lacks? Run off line.

    python -m tests.benchmarks.growing_effects [--each 16]

Wearing drives of the simulator in tests/independent, which shares no code with hdprog, with play
or load-independent friction beside it that grows as the teeth wear, in shapes other than hdprog's.
A limit on lost motion or on hysteresis width is passed, with what the effect adds, after the last
of eight tests. `hdprog run --quick`, as a command of its own, forecasts the hour; beside it stands
a straight line through the figures of the single tests, effect included. CRPS in hours, all counted
up to the horizon. Written to tests/benchmarks/results/growing_effects.json.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.parallel import prepare_numerics
from tests.benchmarks.code_state import digest, imported_by
from tests.benchmarks.whole_drive import COMMAND, EXIT_CODES
from tests.independent.drives import LAWS, WearingDrive, first_crossing, random_wear
from tests.independent.loops import LoopRecord, programme, record_loop, scatter, write_csv
from tests.independent.simulator import ARCMIN, FloatArray
from tests.make_undeclared_effect import REMOUNTING

RESULTS = Path(__file__).parent / "results" / "growing_effects.json"
TESTS = 8
LAST = 0.6  # of the horizon: hour of the last test
RATED = 63.0
_REACHED = 0.04 * RATED  # Nm between which lost motion is counted
_SEED = 47
HANGS_ON = (
    "hdprog.data.drive_folder",
    "hdprog.discovery.drive",
    "hdprog.forecast.crossing",
    "hdprog.inference.fit_loop",
    "hdprog.trend.fitting",
)


def play(torque: FloatArray, zone: float) -> FloatArray:
    """A cubic dead zone of ± zone Nm, ± 1 outside."""
    u = np.clip(torque / zone, -1.0, 1.0)
    return 0.5 * (3.0 * u - u**3)


def friction(torque: FloatArray, zone: float) -> FloatArray:
    """An element that slips after zone Nm: ± 1 behind a reversal, against the motion."""
    state, slid = 0.0, np.zeros(torque.size)
    for at, step in enumerate(np.diff(torque, prepend=0.0)):
        state = float(np.clip(state + step / zone, -1.0, 1.0))
        slid[at] = -state
    return slid


CourseOf = Callable[[WearingDrive, np.random.Generator], FloatArray]

FIGURES = {
    "play": ("lost_motion_arcmin", play, "backlash"),
    "friction": ("hysteresis_width_arcmin", friction, "coulomb_friction"),
}
"""Effect → the figure that it adds to, its shape, and the name that hdprog has for it."""


def added(effect: str, size: FloatArray, zone: float) -> FloatArray:
    """What sizes (n,) in rad add to the effect's figure, in arcmin: twice that size in full."""
    whole = play(np.array([_REACHED]), zone)[0] if effect == "play" else 1.0
    return np.asarray(2.0 * size * whole / ARCMIN)


def tested_at(horizon: float) -> FloatArray:
    """Service hours (tests,) of the tests of a drive with this horizon."""
    return np.linspace(0.0, LAST * horizon, TESTS)


def with_wear(life: WearingDrive, _rng: np.random.Generator) -> FloatArray:
    """Share of an effect's size along a life's hours: from 0 to 1 as the teeth wear."""
    course = life.wear["teeth"] - life.wear["teeth"][0]
    return np.asarray(course / course[-1])


def write_drive(
    folder: Path, effect: str, number: int, course_of: CourseOf = with_wear, seed: int = _SEED
) -> dict[str, Any]:
    """Write a drive whose limit is passed between the last test and the horizon.

    Parameters
    ----------
    folder : to be made
    effect : in `FIGURES`
    number : of the drive; its wear law follows from it
    course_of : draws the share of the effect's size along a life's hours
    seed : of everything random
    """
    rng = np.random.default_rng([seed, number, len(effect)])
    key, shape, _ = FIGURES[effect]
    life = random_wear(rng, LAWS[number % len(LAWS)])
    hours, horizon = life.hours, float(life.hours[-1])
    course = course_of(life, rng)
    largest, zone = float(rng.uniform(1.2e-4, 2.5e-4)), float(rng.uniform(0.8, 2.0))
    figure = life.figures[key] + added(effect, largest * course, zone)
    limit = float(f"{np.interp(rng.uniform(0.68, 0.97) * horizon, hours, figure):.4g}")
    crossed = first_crossing(hours, figure, limit, "above")
    service = np.round(tested_at(horizon), 1)
    if crossed is None or crossed <= service[-1]:
        return write_drive(folder, effect, number + 1000, course_of, seed)
    (folder / "loops").mkdir(parents=True)
    lines = ["test_id,file,service_hours"]
    for at, hour in enumerate(service):
        size = largest * float(np.interp(hour, hours, course))
        record = tested(life, float(hour), size, shape, zone, rng)
        write_csv(record, folder / "loops" / f"t{at}.csv")
        lines.append(f"t{at},loops/t{at}.csv,{hour}")
    (folder / "tests.csv").write_text("\n".join(lines) + "\n", "utf-8")
    (folder / "drive.toml").write_text(
        f'[drive]\nid = "{effect}-{number}"\nmodel = "CSF-25-80"\nratio = 80\nalpha_deg = 30.0\n'
        f"rated_torque_Nm = {RATED}\n[noise]\ntorque_resolution_Nm = 0.1\n"
        f'angle_resolution_rad = 9.77e-6\n[[limits]]\nquantity = "{key}"\nabove = {limit}\n'
        f"[forecast]\nhorizon_hours = {horizon}\n",
        "utf-8",
    )
    return {"law": life.law, "horizon": horizon, "last": float(service[-1]), "crossed": crossed}


def tested(
    life: WearingDrive,
    hour: float,
    size: float,
    shape: Any,
    zone: float,
    rng: np.random.Generator,
) -> LoopRecord:
    """One test, remounted, with the effect at a size in rad."""
    mounted = scatter(life.parameters(hour), REMOUNTING, rng)
    reach = float(rng.choice((63.0, 80.0)))
    segments = programme("two-sided", reach, float(rng.uniform(10.0, 40.0)), rng)
    record = record_loop(mounted, segments, 300, rng)
    return replace(record, angle=record.angle + size * shape(record.true_torque, zone))


def forecast(folder: Path, out: Path, effect: str, truth: dict[str, Any]) -> dict[str, Any]:
    """Run one drive and hold its forecast against the truth."""
    command = [*COMMAND, "run", str(folder), "--out", str(out), "--seed", "1", "--quick"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in EXIT_CODES:
        raise RuntimeError(f"hdprog run {folder} ended with {done.returncode}: {done.stderr}")
    summary, explained = (
        json.loads((out / f"{name}.json").read_text("utf-8")) for name in ("summary", "explain")
    )
    (said,) = (one for one in summary["forecast"] if one["quantity"] != "first_of_all")
    key, _, name = FIGURES[effect]
    remaining = truth["crossed"] - truth["last"]
    levels = said["remaining_hours"]
    times, probability = np.array(said["crossing_probability"]).T
    line = straight_line(summary["tests"], key, said["limit"], truth)
    return truth | {
        "effect": effect,
        "converged": summary["converged"],
        "named": [one["id"] for one in explained["effects"]],
        "origins": [one["origin"] for one in explained["effects"]],
        "followed": name in summary["trend"]["followed_effects"],
        "held_90": inside(remaining, levels["q05"], levels["q95"]),
        "held_50": inside(remaining, levels["q25"], levels["q75"]),
        "without_held_90": inside(
            remaining,
            *(explained["remaining_hours_before"][level] for level in ("q05", "q95")),
        ),
        "crps": round(crps(times, probability, truth["crossed"]), 1),
        "crps_line": round(abs(line - truth["crossed"]), 1),
    }


def inside(value: float, low: float | None, high: float | None) -> bool:
    """Whether a value lies between two levels, of which None is past the horizon."""
    return low is not None and low <= value and (high is None or value <= high)


def crps(times: FloatArray, probability: FloatArray, truth: float) -> float:
    """∫ (F − 1(t ≥ truth))² dt up to the last of the times, from F there."""
    fine = np.linspace(times[0], times[-1], 20_001)
    error = np.interp(fine, times, probability) - (fine >= truth)
    return float(np.trapezoid(error**2, fine))


def straight_line(
    tests: list[dict[str, Any]], key: str, limit: float, truth: dict[str, Any]
) -> float:
    """Hour at which a line through the tests' own medians, effects included, meets the limit."""
    hours = np.array([test["service_hours"] for test in tests])
    values = [(t["figures_with_effects"].get(key) or t["figures"][key])["q50"] for t in tests]
    slope, level = np.polyfit(hours, values, 1)
    met = (limit - level) / slope if slope > 0 else np.inf
    return float(np.clip(met, truth["last"], truth["horizon"]))


def summarised(drives: list[dict[str, Any]], effect: str) -> dict[str, Any]:
    """Counts and means over the drives with an effect."""
    own = [drive for drive in drives if drive["effect"] == effect]
    return {
        "effect": effect,
        "drives": len(own),
        **{
            name: sum(bool(drive[name]) for drive in own)
            for name in ("followed", "converged", "held_90", "held_50", "without_held_90")
        },
        "crps_over_a_straight_lines": round(
            sum(drive["crps"] for drive in own) / sum(drive["crps_line"] for drive in own), 3
        ),
        "crps_over_a_straight_lines_mean_of_horizons": round(
            float(
                np.mean([drive["crps"] / drive["horizon"] for drive in own])
                / np.mean([drive["crps_line"] / drive["horizon"] for drive in own])
            ),
            3,
        ),
    }


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--each", type=int, default=16)
    parser.add_argument("--file", type=Path, default=RESULTS)
    asked = parser.parse_args()
    prepare_numerics()
    drives = []
    with tempfile.TemporaryDirectory() as place:
        for effect in FIGURES:
            for number in range(asked.each):
                folder = Path(place) / f"{effect}-{number}"
                truth = write_drive(folder, effect, number)
                drives.append(forecast(folder, Path(place) / f"o-{folder.name}", effect, truth))
                print(json.dumps(drives[-1]), flush=True)
    results = {
        "command": f"python -m tests.benchmarks.growing_effects --each {asked.each}",
        "code": digest(imported_by(*HANGS_ON)),
        "summary": [summarised(drives, effect) for effect in FIGURES],
        "drives": drives,
    }
    atomic_write_text(asked.file, json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
