"""Simulated repeats, where the truth is known: one drive tested twice, noise drawn anew.

Drives come from the prior that they are fitted with, so that intervals that are right hold the
truth as often as they say. The independent simulator makes the loops; its encoder's noise is white
with an Ornstein-Uhlenbeck part of one of three lengths.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.prepare import prepare, settle_noise
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.parameters import NAMES, in_support
from tests.benchmarks.repeats import DRIVE, WHITE, WIDENED, Fit
from tests.benchmarks.repeats.fits import rng_of, sampled
from tests.independent.loops import programme, record_loop
from tests.independent.simulator import DriveParameters, MeasurementChain

PRIOR = "csf-25-80"
RATED = 63.0
LENGTHS = {"short": 0.02, "medium": 0.07, "long": 0.20}
"""Memory of the noise in parts of the record."""
SHARE = 0.7
"""Of the encoder's noise variance a reading that has memory."""
ANGLE_NOISE = 3e-5  # rad
_READINGS = 600
_RAMP = 30.0  # s
_REPEATS = 2


def name_of(index: int) -> str:
    """Name of a simulated drive; the lengths take turns."""
    return f"simulated {list(LENGTHS)[index % len(LENGTHS)]}: {index}"


def control_fits(index: int, code: str) -> Iterator[Fit]:
    """Both repeats of one simulated drive, with both noises."""
    name = name_of(index)
    length = LENGTHS[name.split()[1].rstrip(":")]
    rng = rng_of("control", index)
    prior = read_prior_file(PRIOR).prior(None)
    drive = replace(Drive.default(), model="CSF-25-80", rated_torque=RATED, alpha_declared=True)
    truth, parameters = _drawn(rng)
    reach = float(rng.choice((63.0, 80.0, 100.0)))
    segments = programme("two-sided", reach, _RAMP, rng)
    duration = sum(segment.duration for segment in segments if segment.recorded)
    chain = MeasurementChain(
        angle_noise=ANGLE_NOISE, correlation_time=length * duration, correlated_share=SHARE
    )
    for cycle in range(_REPEATS):
        record = record_loop(parameters, segments, _READINGS, rng, chain=chain)
        loop = Loop(torque=record.torque, angle=record.angle, time=record.time)
        fit_rng = rng_of(name, cycle)
        prepared = prepare(loop, drive, fit_rng, prior=prior)
        found = {
            WIDENED: settle_noise(prepared.likelihood, prepared.starts, fit_rng),
            WHITE: (prepared.likelihood, prepared.starts),
        }
        for noise, (likelihood, starts) in found.items():
            fit = Fit(name, cycle, DRIVE, noise, code)
            yield sampled(fit, prepared, likelihood, starts, truth)


def _drawn(rng: np.random.Generator) -> tuple[dict[str, np.ndarray], DriveParameters]:
    """A drive from the prior inside the hard support, for the fit and for the simulator."""
    prior = read_prior_file(PRIOR).prior(None)
    while True:
        truth = prior.to_physical(prior.sample(1, rng))
        if in_support(truth, Drive.default().alpha).all():
            values = {name: float(truth[name][0]) for name in NAMES}
            return {name: np.asarray(truth[name]) for name in NAMES}, DriveParameters(**values)
