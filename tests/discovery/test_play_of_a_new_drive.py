"""Play on a drive whose teeth are new: teeth far too soft stand in for it, and nothing is left.

A fit bent so reports the stiffness a fifth too low and more than twice the lost motion, to its
noise. The search has to begin where the teeth are as new drives' are.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.discovery.empirical import over_threshold
from hdprog.discovery.search import Traced, base_model, trace
from hdprog.inference.effect_starts import strained
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from hdprog.physics.parameters import NAMES
from tests.physics.table2 import INITIAL

PRIOR = read_prior_file("csf-25-80").prior(None)
SOME = tuple(BY_ID[name] for name in ("torque_offset", "microslip", "backlash", "cup_hardening"))


def record(play: float, width: float, seed: int) -> Loop:
    """±80 Nm and back with play in rad; 6e-6 rad and 0.04 Nm of noise."""
    rng = np.random.default_rng(seed)
    turns = np.interp(np.arange(1000), [0, 200, 600, 999], [0.0, 1.0, -1.0, 1.0])
    torque = 80.0 * turns
    angle = predict(torque, INITIAL) + 0.5 * play * np.tanh(torque / width)
    angle += 6e-6 * rng.standard_normal(torque.size)
    return Loop(torque + 0.04 * rng.standard_normal(torque.size), angle, np.linspace(0, 40, 1000))


@lru_cache
def searched(play: float, width: float) -> Traced:
    prepared = prepare(
        record(play, width, 61), Drive.default(), np.random.default_rng(0), prior=PRIOR
    )
    return trace([prepared], [np.random.SeedSequence(1)], SOME)[0]


@pytest.mark.parametrize(("play", "width"), [(1.6e-4, 0.25), (3e-4, 0.1)])
def test_it_is_named_though_the_drive_model_leaves_nothing(play: float, width: float) -> None:
    found = searched(play, width)
    assert over_threshold([found.steps[0].terms]) <= 0.0  # no curve finds anything left
    assert found.final.ids == ("backlash",)
    likelihood, point = found.final.likelihood, found.final.start.point
    seen = likelihood.effect_values(point[None])["backlash"]["play"]
    assert float(seen[0, 0]) == pytest.approx(play, rel=0.1)


def test_parameters_far_out_are_told() -> None:
    prepared = prepare(
        record(3e-4, 0.1, 61), Drive.default(), np.random.default_rng(0), prior=PRIOR
    )
    model = base_model(prepared, np.random.default_rng(1))
    far = dict(zip(NAMES, strained(model.likelihood, model.start), strict=True))
    assert far["b"] < -2.5
    assert far["mu"] == 0.0


def test_without_play_nothing_is_named() -> None:
    found = searched(0.0, 0.25)
    assert found.final.ids == ()
    assert not strained(found.base.likelihood, found.base.start).any()
