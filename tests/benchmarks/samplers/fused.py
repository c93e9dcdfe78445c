"""hdprog's likelihood in NumPy beside one loop over the blocks in machine code.

    python -m tests.benchmarks.samplers.fused

The loop evaluates the same log likelihood for a batch of points, block after block, without an
array in between: on one core, in float64, with the same arithmetic (Numba, fastmath off). It is
what the likelihood would cost if the call of NumPy functions and the memory between them cost
nothing. The two are compared at draws of the posterior and of the prior before they are timed;
results/fused.json takes the times, and the next summary of `run` shows them.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_write_text
from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.sampler import RidgePosterior, initial_states
from hdprog.inference.starting_points import StartingPoint, starting_points
from hdprog.parallel import prepare_numerics
from hdprog.physics.drive_model import predict
from hdprog.physics.parameters import NAMES, FloatArray
from tests.benchmarks.calibration.loops import DRIVE, TWO_SIDED, prior_of
from tests.benchmarks.samplers.log_density import peer
from tests.benchmarks.samplers.summary import fused_words

RESULTS = Path(__file__).parent / "results"
RECORDS = (
    (50, False),
    (150, False),
    (300, False),
    (400, False),
    (300, True),
    (400, True),
    (600, True),
)
"""Blocks, and whether they are averages: a record of no more readings than that keeps them all."""
BATCHES = (48, 96)
"""Positions that one call of the density gets: half the walkers, or all of them."""
TOLERANCE = 1e-9
_READINGS_A_BLOCK = 12
_ROUNDS = 60
_LARGEST, _NOISE = 90.0, 1e-5  # Nm, rad
_SEED = 72
Batch = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Record:
    """A record reduced to a number of blocks.

    Attributes
    ----------
    likelihood, starts : of the record, its noise white
    averaged : whether blocks stand for more than one reading
    """

    likelihood: LoopLikelihood
    starts: list[StartingPoint]
    averaged: bool


def record(blocks: int, *, averaged: bool) -> Record:
    """A two-sided loop and a half, of a drive at the prior's median, in so many blocks."""
    rng = np.random.default_rng([_SEED, blocks, averaged])
    prior = prior_of(TWO_SIDED)
    readings = blocks * (_READINGS_A_BLOCK if averaged else 1)
    turns = np.array([0.0, 1.0, -1.0, 1.0]) * _LARGEST
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    torque = np.interp(np.linspace(0.0, travel[-1], readings), travel, turns)
    median = {name: value[0] for name, value in prior.to_physical(prior.mean[None]).items()}
    angle = predict(torque, {name: median[name] for name in NAMES}, DRIVE.alpha)
    angle = angle + _NOISE * rng.standard_normal(readings)
    loop = Loop(torque=torque, angle=angle, time=np.arange(readings, dtype=np.float64))
    points = turning_points(loop.torque)
    reduced = reduce_loop(loop, points, 0.0, max_blocks=blocks)
    noise = NoiseModel.white(_NOISE / np.sqrt(reduced.count))
    likelihood = LoopLikelihood(reduced, prior, DRIVE.alpha, noise)
    return Record(likelihood, starting_points(likelihood, rng), averaged)


@lru_cache(maxsize=2)
def _compiled(fastmath: bool) -> Callable[..., None]:
    """The loop over points and blocks, compiled."""
    numba: Any = peer("numba")

    def loop(
        points: FloatArray,
        torque: FloatArray,
        variance: FloatArray,
        half: FloatArray,
        averaged: bool,
        starts: Any,
        rising: Any,
        reached: FloatArray,
        data: FloatArray,
        sd: FloatArray,
        offset: FloatArray,
        s: float,
        k: float,
        softplus_scale: float,
        out: FloatArray,
    ) -> None:
        samples, stretches, tangent = torque.size, starts.size, s / k
        for draw in range(points.shape[0]):
            K_F, K_W = math.exp(points[draw, 0]), math.exp(points[draw, 1])
            a, b = math.exp(points[draw, 2]), math.exp(points[draw, 3])
            T_T = softplus_scale * _softplus(points[draw, 4])
            c, T_i = -math.exp(points[draw, 5]), math.exp(points[draw, 6])
            mu = math.exp(points[draw, 7])
            fraction = math.exp(-_softplus(-points[draw, 8]))
            # Slopes of the envelope: as the wave generator is driven, and as it is drawn back.
            pull, push = s + mu * k, s - mu * k
            pull_stiffness, push_stiffness = K_W * (k - mu * s), K_W * (k + mu * s)
            falling = mu * c
            small = a * T_T < 1e-9 * b
            growth = 1.0 if small else a
            relative, beyond = growth / b, a * T_T + b
            lower = _envelope(torque[0], falling, T_i, pull, push, pull_stiffness, push_stiffness)
            upper = -_envelope(-torque[0], falling, T_i, pull, push, pull_stiffness, push_stiffness)
            current = lower + fraction * (upper - lower)
            squares = along = 0.0
            for number in range(stretches):
                sign = 1.0 if rising[number] else -1.0
                end = starts[number + 1] if number + 1 < stretches else samples
                before = sign * current
                for at in range(starts[number], end):
                    here = torque[at]
                    slip = sign * max(
                        _envelope(
                            sign * here, falling, T_i, pull, push, pull_stiffness, push_stiffness
                        ),
                        before,
                    )
                    magnitude = abs(here)
                    meshing = min(magnitude, T_T)
                    mesh = meshing / b if small else math.log1p(meshing * relative) / growth
                    mesh += (magnitude - meshing) / beyond
                    if averaged and magnitude < T_T:
                        stiffness = a * magnitude + b
                        mesh -= 0.5 * variance[at] * a / (stiffness * stiffness)
                    angle = math.copysign(mesh, here) if here != 0.0 else 0.0
                    if averaged and 2 * half[at] > magnitude:
                        above = _area(abs(here + half[at]), growth, b, T_T, small, beyond)
                        below = _area(abs(here - half[at]), growth, b, T_T, small, beyond)
                        angle = (above - below) / (2 * half[at])
                    angle += tangent * slip + here / K_F
                    left = data[at] - angle / sd[at]
                    squares += left * left
                    along += left * offset[at]
                at_end = _envelope(
                    sign * reached[number], falling, T_i, pull, push, pull_stiffness, push_stiffness
                )
                current = sign * max(at_end, before)
            out[draw] = -0.5 * (samples - 1) * math.log(squares - along * along)

    def softplus(value: float) -> float:
        return max(value, 0.0) + math.log1p(math.exp(-abs(value)))

    def envelope(
        pushed: float,
        falling: float,
        T_i: float,
        pull: float,
        push: float,
        pull_stiffness: float,
        push_stiffness: float,
    ) -> float:
        friction = max(falling * (abs(pushed) - T_i), 0.0)
        drawn_back = min(pushed * pull - friction, 0.0) / pull_stiffness
        return drawn_back + max(pushed * push - friction, 0.0) / push_stiffness

    def area(
        magnitude: float, growth: float, b: float, T_T: float, small: bool, beyond: float
    ) -> float:
        meshing = min(magnitude, T_T)
        bent, further = meshing * growth / b, magnitude - meshing
        if small:
            whole, at_end = 0.5 * meshing * meshing / b, meshing / b
        else:
            at_end = math.log1p(bent) / growth
            if bent < 1e-3:
                whole = bent * bent * (1 / 2 - bent * (1 / 6 - bent * (1 / 12 - bent / 20)))
            else:
                whole = (1 + bent) * math.log1p(bent) - bent
            whole *= b / (growth * growth)
        return whole + further * (at_end + 0.5 * further / beyond)

    compile_: Any = numba.njit(fastmath=fastmath)
    _softplus, _envelope, _area = compile_(softplus), compile_(envelope), compile_(area)
    compiled: Callable[..., None] = compile_(loop)
    return compiled


def fused(likelihood: LoopLikelihood, *, fastmath: bool = False) -> Batch:
    """The fused log likelihood of points (draws, 9), for white noise and no effects."""
    path, compiled = likelihood.reduced.path, _compiled(fastmath)
    averaged = path.variance is not None
    variance = path.variance if path.variance is not None else np.zeros(1)
    half = path.half_width if averaged else np.zeros(1)
    reached, data = np.ascontiguousarray(path.reached), likelihood._data
    offset, sd = likelihood._whitened_offset, likelihood.noise.sd
    s, k = math.sin(likelihood.alpha), math.cos(likelihood.alpha)
    scale = likelihood.prior.softplus_scale

    def call(points: FloatArray) -> FloatArray:
        out = np.empty(len(points))
        compiled(
            points,
            path.torque,
            variance,
            half,
            averaged,
            path.starts,
            path.rising,
            reached,
            data,
            sd,
            offset,
            s,
            k,
            scale,
            out,
        )
        return out

    return call


def deviation(one: Record, loop: Batch) -> float:
    """Largest deviation of the loop's log likelihood from hdprog's, over its size.

    At draws of the Gaussian about the best mode and at draws of the prior.
    """
    likelihood, rng = one.likelihood, np.random.default_rng([_SEED, 1])
    drawn = np.hstack([likelihood.prior.sample(300, rng), rng.logistic(size=(300, 1))])
    drawn = drawn[likelihood.supported(drawn)]
    near = one.starts[0].point + rng.standard_normal((300, COUNT + 1)) @ (
        np.linalg.cholesky(one.starts[0].covariance).T
    )
    points = np.vstack([drawn, near[likelihood.supported(near)]])
    right = likelihood.log_likelihood(points)
    return float(np.max(np.abs(loop(points) - right) / np.maximum(np.abs(right), 1.0)))


def microseconds(call: Batch, at: FloatArray) -> float:
    """Of one call: the least over rounds, since what disturbs a clock only adds to it."""
    call(at)
    best = math.inf
    for _ in range(_ROUNDS):
        started = time.perf_counter()
        for _ in range(5):
            call(at)
        best = min(best, (time.perf_counter() - started) / 5)
    return 1e6 * best


def timed(one: Record) -> tuple[list[dict[str, Any]], float]:
    """Times by batch, and the largest deviation. Raises SystemExit where it is too large."""
    likelihood = one.likelihood
    plain, fast = fused(likelihood), fused(likelihood, fastmath=True)
    off = deviation(one, plain)
    if off > TOLERANCE:
        raise SystemExit(
            f"the fused loop is not hdprog's likelihood at {likelihood.blocks} blocks (largest "
            f"deviation {off:.1e}, at most {TOLERANCE:g} is allowed): it must follow the model "
            "before it is timed"
        )
    posterior, rng = RidgePosterior(likelihood), np.random.default_rng([_SEED, 2])
    times = []
    for batch in BATCHES:
        states = initial_states(posterior, one.starts, rng, ensembles=1, walkers=batch)
        position = states[0].position[0]
        points = np.ascontiguousarray(posterior.points(position))
        own, loop, fast_loop, density = (
            microseconds(call, at) / batch
            for call, at in (
                (likelihood.log_likelihood, points),
                (plain, points),
                (fast, points),
                (posterior, position),
            )
        )
        times.append(
            {
                "blocks": likelihood.blocks,
                "averaged": one.averaged,
                "batch": batch,
                "own_us": own,
                "fused_us": loop,
                "ratio": own / loop,
                "fastmath_us": fast_loop,
                "density_us": density,
            }
        )
    return times, off


def main() -> None:
    """Time all lengths and batches and write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=RESULTS)
    asked = parser.parse_args()
    prepare_numerics()
    times, off = [], 0.0
    for blocks, averaged in RECORDS:
        these, deviates = timed(record(blocks, averaged=averaged))
        times += these
        off = max(off, deviates)
    found = {
        "date": datetime.now(UTC).date().isoformat(),
        "command": "OMP_NUM_THREADS=1 python -m tests.benchmarks.samplers.fused",
        "numpy": np.__version__,
        "numba": metadata.version("numba"),
        "rounds": _ROUNDS,
        "deviation": off,
        "times": [
            {k: float(f"{v:.5g}") if isinstance(v, float) else v for k, v in one.items()}
            for one in times
        ],
    }
    asked.folder.mkdir(parents=True, exist_ok=True)
    atomic_write_text(asked.folder / "fused.json", json.dumps(found, indent=1) + "\n")
    print(fused_words(found))


if __name__ == "__main__":
    main()
