"""Drives drawn from the priors that they are judged with: wear, tests, loops, and what comes after.

What a drive does up to its last test is drawn here from the equations of
`hdprog.trend.state_space`, without its filter; what it does afterwards is the forecast's own
process, so that ranks test the inference and not the choice of a law of wear. The pace of wear is
less spread than in the shipped prior, in the draw and in the fit alike: at its far ends a drive is
worn out, or as new, at every test. Drives with teeth stiffer than a trend believes are drawn anew.
So are drives whose records no engineer would take for a gear's, by their stiffness, their softest
part or their area: a choice by what is measured leaves ranks uniform.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from types import SimpleNamespace
from typing import cast

import numpy as np

from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.data.loop import Loop
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.priors import Prior
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.physics.parameters import FloatArray, in_support
from hdprog.physics.torque_path import TorquePath
from hdprog.trend.ahead import simulate_ahead, worn_ahead
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.trend_density import FARTHEST_DEVIATE, MOST_WEAR
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior, possible, to_loop
from hdprog.trend.wear_prior import WearPrior, read_wear_prior
from tests.independent.drives import first_crossing

SEED = 81
TESTS = 5
NOW, HORIZON = 1500.0, 4000.0
"""Hours of the last test, and up to which a crossing counts."""
PACE = 0.7  # standard deviation of its logarithm
READINGS = 200
NOISE = (4e-6, 3e-5)  # rad, drawn evenly in the logarithm
TORQUES = (63.0, 80.0, 100.0)
LIMITS = (
    Limit("lost_motion_arcmin", 1.2, "above"),
    Limit("secant_stiffness_Nm_per_rad", 22_000.0, "below", 14.0),
    Limit("hysteresis_width_arcmin", 0.32, "below"),
)
DRIVE = replace(
    Drive.default(),
    model="CSF-25-80",
    rated_torque=63.0,
    alpha_declared=True,
    limits=LIMITS,
    forecast=ForecastSettings(HORIZON),
)
OPERATION = Operation(DRIVE.alpha, 63.0, 63.0)
_STIFFNESS = (2_000.0, 200_000.0)  # Nm/rad, span of torque over span of angle
_SOFTEST = 5.0  # times the compliance of a branch that a twentieth of it may have
_AREA = (0.003, 0.3)  # of a cycle, over the rectangle of its spans
_GRID = 400
_DRIVE, _FIT = range(2)  # streams of random numbers of one drive


@dataclass(frozen=True)
class Drawn:
    """A drive and what becomes of it.

    Attributes
    ----------
    loops, hours : of its tests
    deviates : (9,) of the hyperparameters
    now : (8,) unconstrained coordinates just after the last test, without its scatter
    later : (hours, 8) coordinates at `LATER`
    crossings : hours at which each of `LIMITS` is first crossed; infinite where it is not
    past : whether each is crossed at the last test
    """

    loops: tuple[Loop, ...]
    hours: FloatArray
    deviates: FloatArray
    now: FloatArray
    later: FloatArray
    crossings: tuple[float, ...]
    past: tuple[bool, ...]


LATER = (0.5 * (NOW + HORIZON), HORIZON)


@lru_cache(maxsize=1)
def loop_prior() -> Prior:
    """The prior of the loops."""
    return read_prior_file("csf-25-80").prior(None)


@lru_cache(maxsize=1)
def wear_prior() -> WearPrior:
    """The shipped prior of wear with less spread of the pace."""
    shipped = read_wear_prior()
    content = shipped.model_dump()
    content["wear_rate"]["log_sd"] = PACE
    return WearPrior.model_validate(content)


def fit_rng(index: int) -> np.random.Generator:
    """Random numbers of a drive's fits."""
    return np.random.default_rng([SEED, index, _FIT])


def draw(index: int) -> Drawn:
    """The drive with that number, always the same; drawn anew until all tests are possible."""
    rng = np.random.default_rng([SEED, index, _DRIVE])
    while True:
        found = _attempt(rng)
        if found is not None:
            return found


def _attempt(rng: np.random.Generator) -> Drawn | None:
    prior, wear = loop_prior(), wear_prior()
    gaps = rng.gamma(2.5, size=TESTS - 1)
    hours = np.concatenate([[0.0], np.cumsum(gaps) / gaps.sum()]) * NOW
    deviates = rng.standard_normal(len(HYPERPARAMETERS))
    if np.abs(deviates).max() > FARTHEST_DEVIATE:
        return None
    values = Hyperparameters.of(deviates[None], wear)
    tests = cast(
        "list[LoopEvidence]",
        [
            SimpleNamespace(service_hours=h, event=None, load_hours=None, temperature_C=None)
            for h in hours
        ],
    )
    grid = np.linspace(NOW, HORIZON, _GRID + 1)
    timeline, _ = Timeline.of(tests, ServiceClock.of(tests), wear, grid)
    steps = Steps.of(timeline, values, StatePrior.of(prior, wear), wear)
    if steps.upto(TESTS).passed.sum() > MOST_WEAR:
        return None
    states, carried = until_now(steps, rng)
    scatter = values.scatter[0] * wear.scales
    met = to_loop(states + scatter * rng.standard_normal(states.shape))
    if not in_support(prior.to_physical(met), DRIVE.alpha).all() or not possible(met).all():
        return None
    loops = tuple(_loop(prior, one, rng) for one in met)
    if not all(_like_a_gear(loop) for loop in loops):
        return None
    ahead = simulate_ahead(steps, rng, (states[-1:], carried[None]), TESTS, wear.rate_ahead)[0]
    paths = to_loop(worn_ahead(steps, states[-1:], ahead[None], wear.worn_out, rng)[0][0])
    crossings, past = zip(*(_crossing(limit, paths, grid) for limit in LIMITS), strict=True)
    return Drawn(
        loops,
        hours,
        deviates,
        paths[0],
        paths[np.searchsorted(grid, LATER)],
        crossings,
        past,
    )


def until_now(steps: Steps, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """States (tests, 8) at the tests, and what the last carries: loadings, running-in, rate."""
    size = steps.size
    x = steps.initial_mean + np.sqrt(steps.initial_variance) * rng.standard_normal(size)
    loadings = steps.loading_mean[0] + np.sqrt(steps.loading_variance) * rng.standard_normal(size)
    extent = steps.running_in[0] + np.sqrt(steps.running_in[1]) * rng.standard_normal()
    rate, states = 0.0, []
    for time in range(TESTS):
        passed, departure = steps.passed[0, time], np.sqrt(steps.departure[0, time])
        turn, lead, common = rng.standard_normal(3)
        # A random walk's mean over a stretch, given where it ends (Brownian bridge).
        meanwhile = rate + departure * (turn / 2 + lead / np.sqrt(12))
        along = steps.settled[0, time] * extent + passed * meanwhile
        along += np.sqrt(steps.shared[0, time]) * common
        walk, ends = np.sqrt(steps.loading_walk[0, time]), rng.standard_normal(size)
        pace = loadings + walk * (ends / 2 + rng.standard_normal(size) / np.sqrt(12))
        loadings = loadings + walk * ends
        x = x + pace * steps.wear[0, time] + along * steps.direction
        x = x + np.sqrt(steps.own[0, time]) * rng.standard_normal(size)
        rate += departure * turn
        states.append(x)
    return np.array(states), np.concatenate([loadings, [extent, rate]])


def _crossing(limit: Limit, paths: FloatArray, grid: FloatArray) -> tuple[float, bool]:
    values = figure_paths(FigureRequest.of(limit), paths, loop_prior(), OPERATION)
    at = first_crossing(grid, values, limit.threshold, limit.direction)
    return (np.inf, False) if at is None else (at, at == NOW)


def _loop(prior: Prior, coordinates: FloatArray, rng: np.random.Generator) -> Loop:
    """Two-sided loop with white noise, an arbitrary zero and an unknown slip at its beginning."""
    top = float(rng.choice(TORQUES))
    turns = [0.0, top, -top, top]
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    at = np.linspace(0.0, travel[-1], READINGS)
    every = np.union1d(at, travel)
    path = TorquePath.exact(np.interp(every, travel, turns))
    parameters = prior.to_physical(coordinates[None])
    clean = torsion_angle(path, parameters, DRIVE.alpha, initial_fraction=rng.uniform(size=1))[0]
    chosen = np.searchsorted(every, at)
    noise = float(np.exp(rng.uniform(*np.log(NOISE))))
    angle = clean[chosen] + noise * rng.standard_normal(READINGS) + rng.uniform(-1e-3, 1e-3)
    return Loop(torque=path.torque[chosen], angle=angle, time=at / 2.0)


def _like_a_gear(loop: Loop) -> bool:
    """Whether a record is that of a strain wave gear, by any judgement."""
    if not np.isfinite(loop.angle).all():
        return False
    torque, angle = np.ptp(loop.torque), np.ptp(loop.angle)
    bottom = int(np.argmin(loop.torque))
    top = int(np.argmax(loop.torque[:bottom]))
    falling, rising = slice(top, bottom + 1), slice(bottom, None)
    at = np.linspace(-0.95, 0.95, 39) * torque / 2
    down = np.interp(at, loop.torque[falling][::-1], loop.angle[falling][::-1])
    up = np.interp(at, loop.torque[rising], loop.angle[rising])
    area = float(np.mean(down - up) / angle)
    softest = np.max(np.diff([down, up])) / (at[1] - at[0]) * torque / angle
    return bool(
        _STIFFNESS[0] < torque / angle < _STIFFNESS[1]
        and _AREA[0] < area < _AREA[1]
        and softest < _SOFTEST
    )
