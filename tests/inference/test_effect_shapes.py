"""Stiffness beside an effect that a simulator which shares no code draws in another shape."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.data.loop import Loop
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.sampling_plan import QUICK
from hdprog.physics.effects import BY_ID
from hdprog.physics.figures import FigureRequest
from tests.independent.loops import LoopKind, random_loop
from tests.independent.simulator import DriveParameters, true_figures
from tests.inference.test_linearised_effects import DRIVE


@pytest.mark.parametrize(
    ("name", "kind", "size", "seed"),
    [
        # The angle as |T|^2.5, where a cubic is expected.
        ("cup_hardening", "two-sided", 1.5e-4, 5),
        # A reading that lags by a tenth of the torque: what travels is the load, not the reading.
        ("torque_sensor_hysteresis", "multi-cycle", 4e-4, 2),
    ],
)
def test_stiffness_beside_an_effect_of_another_shape(
    name: str, kind: LoopKind, size: float, seed: int
) -> None:
    record = random_loop(np.random.default_rng(seed), kind, effects={name: size})
    truth = record.truth["parameters"]
    assert isinstance(truth, dict)
    exact = true_figures(DriveParameters(**truth), reference_torque=63.0, secant_torque=63.0)
    request = FigureRequest("secant_stiffness_Nm_per_rad", 63.0)
    posterior = fit_loop(
        Loop(record.torque, record.angle, record.time),
        DRIVE,
        np.random.default_rng(0),
        prior=read_prior_file("csf-25-80").prior(None),
        effects=(BY_ID[name],),
        plan=QUICK,
    )
    draws = posterior.figures((request,))[request.key]
    off = abs(float(np.median(draws)) - exact[request.key]) / float(np.std(draws))
    assert off < 3.0
