"""How far do wrong readings move a fit? Run off line, `--help` says how.

Records of `tests.independent.loops`, which shares no code with hdprog, get 2 % wrong readings: of
the angle (either sign, or always up) or of the torque. Each is fitted twice: as it is, and with
just those readings set aside, as if someone had known them. Their difference is what the errors
did; that readings are missing moves both alike.

Written to tests/benchmarks/results/outliers.json, by kind of error: the shift of the figures of
merit in posterior standard deviations, how many readings were missed, the largest of these in
standard deviations of a reading's noise, and the sound readings that were set aside.
"""

from __future__ import annotations

import argparse
import json
import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

import numpy as np

import hdprog.inference.prepare as preparing
from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.posterior import Posterior
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.summarise import figure_requests
from hdprog.parallel import prepare_numerics
from hdprog.physics.parameters import FloatArray
from tests.independent.loops import KINDS as PROGRAMMES
from tests.independent.loops import random_loop
from tests.independent.simulator import MeasurementChain

RESULTS = Path(__file__).parent / "results" / "outliers.json"
SEED = 78
SHARE = 0.02
DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
SAMPLES = (400, 1500, 4000)


@dataclass(frozen=True)
class Errors:
    """A kind of wrong readings; sizes are log-uniform, in noise standard deviations."""

    name: str
    smallest: float
    largest: float
    channel: str = "angle"
    one_sided: bool = False


KINDS = (
    Errors("angle, 10 to 1 000 times the noise", 10, 1000),
    Errors("angle, 4 to 50 times the noise, always up", 4, 50, one_sided=True),
    Errors("angle, 3 to 12 times the noise", 3, 12),
    Errors("torque, 5 to 500 times the noise", 5, 500, channel="torque"),
)


@dataclass(frozen=True)
class Effect:
    """What the errors did to one record."""

    kind: str
    shift: FloatArray
    ratio: FloatArray
    missed: int
    largest_missed: float
    lost: int
    wrong: int


def fitted(loop: Loop, seed: int) -> Posterior:
    """Posterior of a record."""
    prior = read_prior_file("csf-25-80").prior(None)
    return fit_loop(loop, DRIVE, np.random.default_rng(seed), prior=prior)


def one(number: int) -> Effect:
    """Draw a record, put errors into it, and fit it without and with knowing them."""
    rng = np.random.default_rng([SEED, number])
    kind = KINDS[number // len(PROGRAMMES) % len(KINDS)]
    chain = MeasurementChain(
        torque_noise=float(rng.uniform(0.02, 0.08)),
        angle_noise=float(np.exp(rng.uniform(math.log(5e-6), math.log(2e-5)))),
    )
    samples = SAMPLES[number % len(SAMPLES)]
    record = random_loop(rng, PROGRAMMES[number % len(PROGRAMMES)], samples=samples, chain=chain)
    slope = float(np.ptp(record.angle) / np.ptp(record.torque))
    noise = math.hypot(chain.angle_noise, slope * chain.torque_noise)
    wrong = rng.random(samples) < SHARE
    size = np.exp(rng.uniform(math.log(kind.smallest), math.log(kind.largest), samples))
    size *= 1.0 if kind.one_sided else rng.choice([-1.0, 1.0], samples)
    error = np.where(wrong, size * noise, 0.0)
    loop = Loop(torque=record.torque, angle=record.angle, time=record.time)
    if kind.channel == "torque":
        loop = replace(loop, torque=loop.torque + error / slope)
    else:
        loop = replace(loop, angle=loop.angle + error)
    blind = fitted(loop, number)
    with patch.object(preparing, "spikes", lambda *_: wrong):
        known = fitted(loop, number)
    requests = figure_requests(DRIVE, known.operation)
    without, with_them = known.figures(requests), blind.figures(requests)
    missed = wrong & blind.kept
    return Effect(
        kind.name,
        np.array([(with_them[key].mean() - at.mean()) / at.std() for key, at in without.items()]),
        np.array([with_them[key].std() / at.std() for key, at in without.items()]),
        int(missed.sum()),
        float(np.abs(size[missed]).max(initial=0.0)),
        int((~wrong & ~blind.kept).sum()),
        int(wrong.sum()),
    )


def summary(found: list[Effect]) -> dict[str, object]:
    """What there is to say of one kind of error."""
    shift = np.abs(np.array([each.shift for each in found]))
    ratio = np.array([each.ratio for each in found])
    return {
        "records": len(found),
        "shift_rms": round(float(np.sqrt(np.mean(shift**2))), 3),
        "shift_largest": round(float(shift.max()), 3),
        "shift_within_0.2": round(float(np.mean(shift < 0.2)), 3),
        "sd_ratio_median": round(float(np.median(ratio)), 3),
        "wrong_readings": sum(each.wrong for each in found),
        "missed": sum(each.missed for each in found),
        "largest_missed": round(max(each.largest_missed for each in found), 1),
        "sound_readings_set_aside": sum(each.lost for each in found),
    }


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, default=6 * len(KINDS) * len(PROGRAMMES))
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    with ProcessPoolExecutor(asked.workers, initializer=prepare_numerics) as executor:
        found = list(executor.map(one, range(asked.records)))
    by_kind = {kind.name: [each for each in found if each.kind == kind.name] for kind in KINDS}
    results = {
        "command": f"python -m tests.benchmarks.outliers --records {asked.records}",
        "seed": SEED,
        "share_of_wrong_readings": SHARE,
        "kinds": {name: summary(each) for name, each in by_kind.items() if each},
    }
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
