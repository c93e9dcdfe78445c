"""Loops of the prior's mean drive under noise that remembers, and what a fit begins with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.prepare import Prepared, prepare, settle_noise
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.torque_path import TorquePath

READINGS = 280
TORQUE = np.interp(np.linspace(0, 3, READINGS), [0, 1, 2, 3], [80.0, -80.0, 80.0, -80.0])
Settled = tuple[Prepared, LoopLikelihood, list[StartingPoint]]


def slow(rng: np.random.Generator, kept: float, pushed: float) -> np.ndarray:
    """(READINGS,) noise that keeps a share of its last value and is pushed anew, from rest."""
    noise = np.zeros(READINGS)
    for at in range(1, READINGS):
        noise[at] = kept * noise[at - 1] + pushed * rng.standard_normal()
    return noise


def settled(rng: np.random.Generator, errors: np.ndarray) -> Settled:
    """The drive's loop with errors (READINGS,) in rad, its noise found and its modes."""
    drive = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
    prior = read_prior_file("csf-25-80").prior(None)
    clean = torsion_angle(
        TorquePath.exact(TORQUE),
        prior.to_physical(prior.mean[None]),
        drive.alpha,
        initial_fraction=np.array([0.5]),
    )[0]
    prepared = prepare(Loop(torque=TORQUE, angle=clean + errors), drive, rng, prior=prior)
    return prepared, *settle_noise(prepared.likelihood, prepared.starts, rng)
