"""Noise with a memory, or something that acts: what is many times the white noise is told."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.discovery.search import Traced, trace
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.drive_model import predict
from hdprog.physics.parameters import FloatArray
from tests.physics.table2 import POST_TEST

PRIOR = read_prior_file("csf-25-80").prior(None)
NOISE = 5e-6  # rad, white


def searched(readings: int, beside: FloatArray) -> Traced:
    """Table 2's worn drive, ±60 Nm in 40 s, with another angle in rad and white noise beside."""
    turns = np.interp(np.linspace(0, 1, readings), [0.0, 0.2, 0.6, 1.0], [0.0, 1.0, -1.0, 1.0])
    torque: FloatArray = np.asarray(60.0 * turns, dtype=np.float64)
    time: FloatArray = np.linspace(0.0, 40.0, readings)
    loop = Loop(torque, predict(torque, POST_TEST) + beside, time)
    prepared = prepare(loop, Drive.default(), np.random.default_rng(0), prior=PRIOR)
    return trace([prepared], [np.random.SeedSequence(1)])[0]


@pytest.mark.parametrize(("corners", "seed"), [(24, 2), (36, 0)])
def test_a_crooked_drift_of_eight_times_the_noise_is_no_noise(corners: int, seed: int) -> None:
    # Straight pieces: a smooth curve follows them hardly better than noise with a memory does.
    rng = np.random.default_rng(seed)
    places = np.linspace(0.0, 1.0, corners)
    crooked = np.interp(np.linspace(0, 1, 300), places, rng.standard_normal(corners).cumsum())
    crooked -= crooked.mean()
    drift = 8 * NOISE * crooked / crooked.std()
    found = searched(300, drift + NOISE * rng.standard_normal(300))
    assert found.final.term is not None
    assert found.final.term.coordinate == "time"
    assert not found.final.ids
    assert found.final.misfit < 1.2 * found.final.likelihood.blocks


@pytest.mark.parametrize("memory", [0.02, 0.2])
def test_noise_with_a_memory_as_large_as_an_encoders_stays_noise(memory: float) -> None:
    # Of its mean square 70 %; length in parts of the record.
    for seed in range(2):
        rng = np.random.default_rng(seed)
        kept, steps = np.exp(-1 / (memory * 400)), rng.standard_normal(400)
        remembered = steps.copy()
        for at in range(1, 400):
            remembered[at] = kept * remembered[at - 1] + np.sqrt(1 - kept**2) * steps[at]
        noise = NOISE * (np.sqrt(7 / 3) * remembered + rng.standard_normal(400))
        final = searched(400, noise).final
        assert not final.ids
        assert final.term is None
