"""Friction that follows the torque at once, as textbooks have it, is called by its name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.discovery.search import trace
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.drive_model import predict
from tests.physics.table2 import POST_TEST

DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
PRIOR = read_prior_file("csf-25-80").prior(None)
TIME = 0.4 * np.arange(900)
# A cycle of three minutes, then three of a minute.
TRIANGLE = 63.0 * np.interp(
    np.where(TIME < 180.0, TIME / 180.0, (TIME - 180.0) / 60.0) % 1.0,
    [0.0, 0.25, 0.75, 1.0],
    [0.0, 1.0, -1.0, 0.0],
)
SINE = 63.0 * np.sin(2 * np.pi * TIME / 90.0)


@pytest.mark.parametrize(
    ("name", "torque"), [("viscous_friction", TRIANGLE), ("coulomb_friction", SINE)]
)
def test_ideal_friction_is_named_and_nothing_else(name: str, torque: np.ndarray) -> None:
    rng = np.random.default_rng(4)
    rate = np.gradient(torque, TIME)
    added = -1e-5 * rate if name == "viscous_friction" else -3e-5 * np.sign(rate)
    angle = predict(torque, POST_TEST) + added + 9e-6 * rng.standard_normal(torque.size)
    read = torque + 0.04 * rng.standard_normal(torque.size)
    record = prepare(Loop(read, angle, TIME), DRIVE, rng, prior=PRIOR)
    found = trace([record], [np.random.SeedSequence(1)])[0].final
    assert found.ids == (name,)
    assert found.term is None
    assert np.std(found.residual) < 1.2 * record.noise_floor
