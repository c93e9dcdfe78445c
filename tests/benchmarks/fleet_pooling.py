"""What a new drive with two tests gains from the finished drives of its fleet.

    python -m tests.benchmarks.fleet_pooling [--fleets 12] [--others 6] [--seed 0]

A fleet are drives of one wear law and one horizon from `tests.independent.drives`, each with its
own parameters and pace. The others have eight tests, the new drive the first two of its own; their
loops are simulated as in `prognostics_small`. The new drive is forecast with the shipped wear prior
and with what the others say. Written to tests/benchmarks/results/fleet_pooling.json: how many true
crossings the 90 % and 50 % intervals hold, and the CRPS with the fleet over that without.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.config import Drive, ForecastSettings
from hdprog.forecast.crossing import forecast
from hdprog.forecast.scores import covers, crps
from hdprog.parallel import prepare_numerics
from hdprog.trend.fitting import fit_trend
from hdprog.trend.wear_prior import read_wear_prior
from hdprog.trend.what_tests_say import what_tests_say
from tests.benchmarks.prognostics_small import OPERATION, WearingDrive, wearing_drive
from tests.independent.drives import LAWS
from tests.trend.stand_in import PRIOR

RESULTS = Path(__file__).parent / "results" / "fleet_pooling.json"


def scored(drive: WearingDrive, prior, rng: np.random.Generator) -> list[tuple[float, ...]]:
    """Coverage at 90 and 50 % and CRPS (over the horizon) of the crossings still to come."""
    tests = drive.tests[:2]
    now = tests[-1].service_hours
    trend = fit_trend(tests, PRIOR, prior, rng, quick=True)
    declared = Drive(
        rated_torque=OPERATION.rated_torque,
        limits=tuple(drive.crossings),
        forecast=ForecastSettings(drive.horizon),
    )
    rows = []
    for found in forecast(trend, declared, OPERATION, rng):
        if found.limit is None or drive.crossings[found.limit] <= now:
            continue
        truth = drive.crossings[found.limit]
        hours, probability = found.crossing_probability.T
        rows.append(
            (
                float(covers(found.remaining_hours, 0.05, 0.95, truth - now)),
                float(covers(found.remaining_hours, 0.25, 0.75, truth - now)),
                crps(hours, probability, truth) / drive.horizon,
            )
        )
    return rows


def main() -> None:
    """Run the comparison and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fleets", type=int, default=12)
    parser.add_argument("--others", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    prepare_numerics()
    shipped = read_wear_prior()
    alone: list[tuple[float, ...]] = []
    taught: list[tuple[float, ...]] = []
    for number in range(options.fleets):
        rng = np.random.default_rng([options.seed, number])
        law = LAWS.index(LAWS[number % len(LAWS)])
        horizon = float(np.exp(rng.uniform(np.log(500.0), np.log(20_000.0))))
        drives = [wearing_drive(law, 8, rng, horizon=horizon) for _ in range(options.others + 1)]
        told = [
            what_tests_say(fit_trend(one.tests, PRIOR, shipped, rng, quick=True), rng)
            for one in drives[:-1]
        ]
        learnt = shipped.taught_by([str(n) for n in range(options.others)], told)
        alone += scored(drives[-1], shipped, np.random.default_rng([options.seed, number, 1]))
        taught += scored(drives[-1], learnt, np.random.default_rng([options.seed, number, 1]))
        print(f"fleet {number + 1}: {len(alone)} crossings", flush=True)
    without, with_fleet = np.mean(alone, axis=0), np.mean(taught, axis=0)
    content = {
        "command": f"python -m tests.benchmarks.fleet_pooling --fleets {options.fleets} "
        f"--others {options.others} --seed {options.seed}",
        "crossings": len(alone),
        "without_fleet": dict(
            zip(("90 %", "50 %", "crps_over_horizon"), without.round(4).tolist(), strict=True)
        ),
        "with_fleet": dict(
            zip(("90 %", "50 %", "crps_over_horizon"), with_fleet.round(4).tolist(), strict=True)
        ),
        "crps_ratio": round(float(with_fleet[2] / without[2]), 3),
    }
    atomic_write_text(RESULTS, json.dumps(content, indent=1) + "\n")
    print(json.dumps(content, indent=1))


if __name__ == "__main__":
    main()
