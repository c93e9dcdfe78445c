"""Forecasts on simulated drives whose wear does not follow the model's clock.

    python -m tests.benchmarks.prognostics_small [--drives 40] [--tests 8] [--seed 0]

The drives are those of `tests.independent.drives`: logistic, bilinear, run-in or gamma-process
wear, every test scattered by remounting. Teeth, preload and friction each go a course of their own,
or all the same one (`--courses one`); or all wear regularly, by a power of the hours or towards an
end, but for a drift of each (`--courses regular`).
Their loops are simulated here with white noise of known size, so that a trend costs seconds.
Written to tests/benchmarks/results/prognostics_small.json, by kind of limits and of courses: how
many true crossings the 90 % and 50 % intervals hold, and the CRPS relative to a straight line
through point estimates.

Limits that are `reached` are values that the drive truly has before its horizon, which no forecast
is told: crossings past the horizon are left out by choice, and forecasts seem too late. With
`--limits fixed` the same limits hold for every drive, reached or not.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.forecast.crossing import forecast
from hdprog.forecast.scores import covers, crps, probability_integral_transform
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.fitting import fit_trend
from hdprog.trend.wear_prior import read_wear_prior
from tests.independent.drives import LAWS, REGULAR_LAWS, first_crossing, random_wear
from tests.independent.drives import WearingDrive as Life
from tests.independent.loops import scatter
from tests.inference.inverse import coordinates_of
from tests.trend.stand_in import ALPHA, PRIOR, SimulatedLoop, simulated_loop

RESULTS = Path(__file__).parent / "results" / "prognostics_small.json"
Courses = Literal["own", "one", "regular"]
OPERATION = Operation(ALPHA, 63.0, 63.0)
FIXED = (
    Limit("lost_motion_arcmin", 1.2, "above"),
    Limit("secant_stiffness_Nm_per_rad", 22_000.0, "below", 14.0),
    Limit("hysteresis_width_arcmin", 0.32, "below"),
)
DRIFT = 0.07
REMOUNTING = {"K_F": 0.004, "K_W": 0.006, "b": 0.012, "T_T": 0.008, "T_i": 0.012, "mu": 0.025}


@dataclass(frozen=True)
class WearingDrive:
    """A simulated drive: its tests, its horizon and when each limit is truly crossed."""

    law: str
    tests: list[SimulatedLoop]
    horizon: float
    crossings: dict[Limit, float]


def wearing_drive(
    number: int,
    count: int,
    rng: np.random.Generator,
    fixed: bool = False,
    horizon: float | None = None,
    courses: Courses = "own",
) -> WearingDrive:
    """One drive with `count` tests over 50-80 % of its horizon."""
    laws, drift = (REGULAR_LAWS, DRIFT) if courses == "regular" else (LAWS, 0.0)
    law = laws[number % len(laws)]

    def drawn() -> Life:
        return random_wear(rng, law, horizon, one_course=courses != "own", drift=drift)

    life = drawn()
    while not life.limits:
        life = drawn()
    horizon = float(life.hours[-1])
    gaps = rng.gamma(2.5, size=count - 1)
    last = float(rng.uniform(0.5, 0.8)) * horizon
    tests = []
    for hour in np.concatenate([[0.0], np.cumsum(gaps) / gaps.sum()]) * last:
        mounted = scatter(life.parameters(float(hour)), REMOUNTING, rng).as_dict()
        state = coordinates_of(PRIOR, mounted)
        tests.append(simulated_loop(float(hour), state, rng, float(rng.choice([63, 80, 100]))))
    crossings = {}
    if fixed:
        for limit in FIXED:
            values = life.figures[limit.key]
            crossed = first_crossing(life.hours, values, limit.threshold, limit.direction)
            crossings[limit] = np.inf if crossed is None else crossed
    else:
        for entry in life.limits:
            found: dict[str, Any] = entry
            limit = Limit(
                found["quantity"], found["limit"], found["direction"], found["at_torque_Nm"]
            )
            crossings[limit] = float(found["crossing_hours"])
    return WearingDrive(law, tests, horizon, crossings)


def straight_line(limit: Limit, drive: WearingDrive, now: float) -> float:
    """Crossing of a least-squares line through the tests' point estimates of the figure."""
    points = np.stack([test.own_mode[0] for test in drive.tests])
    values = figure_paths(FigureRequest.of(limit), points, PRIOR, OPERATION)
    slope, level = np.polyfit([test.service_hours for test in drive.tests], values, 1)
    at = (limit.threshold - level) / slope
    away = slope > 0 if limit.direction == "below" else slope < 0
    return drive.horizon if away else float(np.clip(at, now, drive.horizon))


def main() -> None:
    """Run the comparison and print it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=40)
    parser.add_argument("--tests", type=int, default=8)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--full", action="store_true", help="not the quick sampling")
    parser.add_argument("--limits", choices=("reached", "fixed"), default="reached")
    parser.add_argument("--courses", choices=get_args(Courses), default="own")
    parser.add_argument("--wear-prior", type=Path, help="another file like priors/trend.toml")
    options = parser.parse_args()
    wear_prior = read_wear_prior(options.wear_prior)
    scores: dict[str, list[tuple[bool, bool, float, float, float]]] = {}
    converged, started = 0, time.perf_counter()
    for number in range(options.drives):
        rng = np.random.default_rng([options.seed, number])
        fixed = options.limits == "fixed"
        drive = wearing_drive(number, options.tests, rng, fixed, courses=options.courses)
        now = drive.tests[-1].service_hours
        trend = fit_trend(drive.tests, PRIOR, wear_prior, rng, quick=not options.full)
        converged += trend.converged
        declared = Drive(
            rated_torque=OPERATION.rated_torque,
            limits=tuple(drive.crossings),
            forecast=ForecastSettings(drive.horizon),
        )
        for found in forecast(trend, declared, OPERATION, rng):
            if found.limit is None or drive.crossings[found.limit] <= now:
                continue
            truth = drive.crossings[found.limit]
            hours, probability = found.crossing_probability.T
            line = straight_line(found.limit, drive, now)
            name = found.limit.key.split("_")[0]
            scores.setdefault(name, []).append(
                (
                    covers(found.remaining_hours, 0.05, 0.95, truth - now),
                    covers(found.remaining_hours, 0.25, 0.75, truth - now),
                    crps(hours, probability, truth) / drive.horizon,
                    abs(min(truth, drive.horizon) - line) / drive.horizon,
                    probability_integral_transform(hours, probability, truth, rng.uniform()),
                )
            )
            scores.setdefault(drive.law, []).append(scores[name][-1])
    scores["all"] = [score for law in (*LAWS, *REGULAR_LAWS) for score in scores.get(law, [])]
    rows = {key: _row(each) for key, each in scores.items()}
    print(f"{'':26s} {'n':>4s} {'90 %':>6s} {'50 %':>6s} {'CRPS / line':>12s}  PIT tenths")
    for key, row in rows.items():
        print(
            f"{key:26s} {row['crossings']:4d} {row['held_by_90']:6.2f} {row['held_by_50']:6.2f} "
            f"{row['crps_over_line']:12.3f}  {row['pit_tenths']}"
        )
    seconds = (time.perf_counter() - started) / options.drives
    print(f"{converged} of {options.drives} trends converged; {seconds:.1f} s a drive")
    if options.wear_prior is None:
        found = json.loads(RESULTS.read_text("utf-8")) if RESULTS.is_file() else {}
        found[f"{options.limits}, {options.courses}"] = {
            "command": "python -m tests.benchmarks.prognostics_small "
            f"--drives {options.drives} --tests {options.tests} --seed {options.seed} "
            f"--limits {options.limits} --courses {options.courses}"
            + (" --full" if options.full else ""),
            "converged": converged,
            "rows": rows,
        }
        atomic_write_text(RESULTS, json.dumps(found, indent=1) + "\n")


def _row(each: list[tuple[bool, bool, float, float, float]]) -> dict[str, Any]:
    table = np.array(each, dtype=float)
    wide, narrow, score, line, _ = table.mean(axis=0)
    return {
        "crossings": len(each),
        "held_by_90": round(wide, 3),
        "held_by_50": round(narrow, 3),
        "crps_over_line": round(score / line, 3),
        "pit_tenths": np.histogram(table[:, 4], 10, (0, 1))[0].tolist(),
    }


if __name__ == "__main__":
    main()
