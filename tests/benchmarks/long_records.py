"""Does a reduced record give the posterior of its readings? Run off line, `--help` says how.

Records of `tests.independent.loops`, which shares no code with hdprog, are fitted twice: reduced
to blocks, as always, and reading by reading. The draws of the reduced posterior are weighted with
what the likelihood of the readings says of them beyond that of the blocks: the one that a fit
which keeps every reading has, at the torques that were read. The same draws give both posteriors
then, so that their difference holds no Monte-Carlo error; where the weights are too unequal for
that (Pareto k above 0.7), the result says so.

Written to tests/benchmarks/results/long_records.json, by kind of record: the largest and the
root-mean-square shift of a mean over coordinates and figures, in posterior standard deviations,
and the ratios of standard deviations, reduced over full; and how many of the true parameters the
reduced posterior's intervals hold, for where readings share their errors the full one is none.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop, whole_course
from hdprog.data.turning_points import turning_points
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.lazy_arviz import arviz
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.measured_noise import local_slope, reading_noise, reading_sd
from hdprog.inference.noise import NoiseModel
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import settle_noise
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.starting_points import describe
from hdprog.inference.summarise import figure_requests
from hdprog.parallel import prepare_numerics
from hdprog.physics.figures import figures
from hdprog.physics.parameters import NAMES, FloatArray
from tests.independent.loops import LoopKind, LoopRecord, random_loop
from tests.independent.simulator import MeasurementChain

RESULTS = Path(__file__).parent / "results" / "long_records.json"
SEED = 53
DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
_AT_ONCE = 4_000_000  # readings times draws
_MOST_DRAWS = 6000


@dataclass(frozen=True)
class Kind:
    """A kind of record: programme, readings and sensors."""

    name: str
    programme: LoopKind
    samples: int
    sensors: Callable[[np.random.Generator], MeasurementChain]


def sensors(
    torque_step: float = 0.0, angle_step: float = 0.0, correlated: bool = False
) -> Callable[[np.random.Generator], MeasurementChain]:
    """Draws of sensors of these resolutions, with noise like that of the paper's rig."""

    def draw(rng: np.random.Generator) -> MeasurementChain:
        return MeasurementChain(
            torque_noise=float(rng.uniform(0.02, 0.08)),
            torque_step=torque_step,
            angle_noise=float(np.exp(rng.uniform(math.log(5e-6), math.log(2e-5)))),
            angle_step=angle_step,
            correlation_time=10.0 if correlated else 0.0,
            correlated_share=0.5,
        )

    return draw


KINDS = (
    Kind("white noise", "two-sided", 2400, sensors()),
    Kind("one-sided", "one-sided", 2400, sensors()),
    Kind("several cycles", "multi-cycle", 3000, sensors()),
    Kind("minor loops", "minor-loops", 3000, sensors()),
    Kind("quantised torque and angle", "two-sided", 2400, sensors(0.1, 9.77e-6)),
    Kind("coarsely quantised", "two-sided", 2400, sensors(0.5, 4e-5)),
    Kind("correlated noise", "two-sided", 1500, sensors(correlated=True)),
    Kind("a slow cycle of 35 000 rows", "two-sided", 35_000, sensors(0.1, 9.77e-6)),
)


@dataclass(frozen=True)
class Comparison:
    """Reduced against full posterior of one record.

    Attributes
    ----------
    shift : (quantities,) mean of the reduced posterior minus that of the full one, in its SD
    ratio : (quantities,) standard deviation of the reduced posterior over that of the full one
    pareto_k : of the weights
    blocks, same_noise : of the reduction; whether both found the same sort of noise
    """

    names: tuple[str, ...]
    shift: FloatArray
    ratio: FloatArray
    pareto_k: float
    blocks: int
    same_noise: bool


@dataclass(frozen=True)
class Compared:
    """One record: its reduced posterior against the full one, and against the truth.

    Attributes
    ----------
    against_full : the comparison
    below : (8,) share of the reduced posterior below each true parameter
    converged : whether that one did
    """

    against_full: Comparison
    below: FloatArray
    converged: bool


def compared(record: LoopRecord, rng: np.random.Generator) -> Compared:
    """Fit a record reduced, weight its posterior with the likelihood of all readings."""
    loop = Loop(torque=record.torque, angle=record.angle, time=record.time)
    prior = read_prior_file("csf-25-80").prior(None)
    posterior = fit_loop(loop, DRIVE, rng, prior=prior)
    found = against(posterior, likelihood_of_readings(posterior, rng))
    drawn = posterior.prior.to_physical(posterior.points[:, : len(NAMES)])
    below = [float(np.mean(drawn[name] < record.truth["parameters"][name])) for name in NAMES]
    return Compared(found, np.array(below), posterior.converged)


def likelihood_of_readings(posterior: Posterior, rng: np.random.Generator) -> LoopLikelihood:
    """The likelihood of every reading that a fit of the reduced record kept."""
    loop, kept = posterior.loop, posterior.kept
    readings = Loop(torque=loop.torque[kept], angle=loop.angle[kept], time=loop.time[kept])
    noise = reading_noise(readings, posterior.drive.noise)
    points = turning_points(readings.torque, time=readings.time)
    smooth = readings.torque.copy()
    for start, end in pairwise([0, *(points[1:-1] + 1), len(readings)]):
        window = max(5, (end - start) // 60) | 1
        if end - start > window:
            smooth[start:end] = savgol_filter(smooth[start:end], window, 1)
    whole = whole_course(readings, points, noise[0])
    path = replace(whole.path, torque=smooth)
    # The noise of single torques would drown their differences, which the slope is taken from.
    along = posterior.likelihood.at_course(replace(whole, path=path))
    slope = local_slope(smooth, along.angle(posterior.best[None, :])[0])
    reduced = reduce_loop(readings, points, noise[0], max_blocks=len(readings), whole=whole)
    white = NoiseModel.white(reading_sd(slope, *noise))
    likelihood = replace(posterior.likelihood, reduced=reduced, noise=white)
    return settle_noise(likelihood, [describe(likelihood, posterior.best)], rng)[0]


def against(posterior: Posterior, full: LoopLikelihood) -> Comparison:
    """Compare a posterior with the one that its draws make under another likelihood."""
    draws = posterior.points[posterior.thinned(_MOST_DRAWS)]
    at_once = max(1, _AT_ONCE // full.blocks)
    parts = np.array_split(draws, math.ceil(len(draws) / at_once))
    beyond = np.concatenate([full.log_likelihood(part) for part in parts])
    beyond -= posterior.likelihood.log_likelihood(draws)
    log_weights, pareto_k = arviz().psislw(beyond - beyond.max())
    weights = np.exp(log_weights - log_weights.max())
    weights /= weights.sum()
    parameters = posterior.prior.to_physical(draws[:, : len(NAMES)])
    requests = figure_requests(posterior.drive, posterior.operation)
    merit = figures(requests, parameters, posterior.operation)
    values = np.column_stack([draws[:, : len(NAMES)], *merit.values()])
    mean = weights @ values
    sd = np.sqrt(weights @ (values - mean) ** 2)
    return Comparison(
        (*NAMES, *merit),
        (values.mean(axis=0) - mean) / sd,
        values.std(axis=0) / sd,
        float(pareto_k),
        posterior.likelihood.blocks,
        (posterior.likelihood.noise.whitening is None) == (full.noise.whitening is None),
    )


def one(number: int) -> tuple[str, Compared]:
    """Draw a record of the kind whose turn it is and compare."""
    rng = np.random.default_rng([SEED, number])
    kind = KINDS[number % len(KINDS)]
    record = random_loop(rng, kind.programme, samples=kind.samples, chain=kind.sensors(rng))
    return kind.name, compared(record, rng)


def summary(records: list[Compared]) -> dict[str, object]:
    """What there is to say of one kind of record."""
    found = [one.against_full for one in records]
    below = np.array([one.below for one in records])
    shift = np.array([each.shift for each in found])
    ratio = np.array([each.ratio for each in found])
    return {
        "records": len(found),
        "blocks": int(np.median([each.blocks for each in found])),
        "shift_rms": round(float(np.sqrt(np.mean(shift**2))), 3),
        "shift_largest": round(float(np.abs(shift).max()), 3),
        "shift_within_0.1": round(float(np.mean(np.abs(shift) < 0.1)), 3),
        "ratio_median": round(float(np.median(ratio)), 3),
        "ratio_smallest_and_largest": [
            round(float(ratio.min()), 3),
            round(float(ratio.max()), 3),
        ],
        "ratio_within_5_percent": round(float(np.mean(np.abs(ratio - 1) < 0.05)), 3),
        "pareto_k_largest": round(max(each.pareto_k for each in found), 2),
        "same_sort_of_noise": float(np.mean([each.same_noise for each in found])),
        "converged": sum(one.converged for one in records),
        "true_parameters_held_by_90": round(float(np.mean(np.abs(below - 0.5) < 0.45)), 3),
        "true_parameters_held_by_50": round(float(np.mean(np.abs(below - 0.5) < 0.25)), 3),
    }


def main() -> None:
    """Run and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, default=16 * len(KINDS))
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    with ProcessPoolExecutor(asked.workers, initializer=prepare_numerics) as executor:
        found = list(executor.map(one, range(asked.records)))
    results = {
        "seed": SEED,
        "kinds": {
            kind.name: summary([each for name, each in found if name == kind.name])
            for kind in KINDS[: asked.records]
        },
    }
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
