"""The paper's identification: what it finds, where it fails, what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.errors import BadInputError
from hdprog.inference.five_points import identify_record
from hdprog.physics.drive_model import predict
from hdprog.physics.figures import secant_stiffness
from hdprog.physics.parameters import NAMES
from tests.physics.table2 import INITIAL, POST_TEST

ALPHA = math.radians(30)


def loop(parameters: dict[str, float], seed: int, noise: float = 1e-5) -> Loop:
    """A cycle to ± 100 Nm."""
    legs = [np.linspace(0, 100, 76)]
    legs += [np.linspace(100, -100, 151)[1:], np.linspace(-100, 100, 151)[1:]]
    torque = np.concatenate([*legs, np.linspace(100, 0, 101)[1:]])
    values = {name: np.asarray(value) for name, value in parameters.items()}
    rng = np.random.default_rng(seed)
    angle = predict(torque, values, ALPHA) + 3e-4 + noise * rng.standard_normal(torque.size)
    return Loop(torque, angle, source="made.csv")


def test_a_new_drive_keeps_its_stiffness() -> None:
    """Within 3 % at 60 Nm; friction and preload by their product over K_W, within a fifth."""
    found = identify_record(loop(INITIAL, 1), Drive())
    assert found == identify_record(loop(INITIAL, 1), Drive())
    parameters = found.parameters
    values = {name: np.array([value]) for name, value in parameters.items()}
    truth = {name: np.array([value]) for name, value in INITIAL.items()}
    got = secant_stiffness(60.0, values, ALPHA)[0]
    assert got == pytest.approx(secant_stiffness(60.0, truth, ALPHA)[0], rel=0.03)
    assert set(parameters) == set(NAMES)
    assert found.points["A1"][1] < 0
    friction = parameters["mu"] * parameters["c"] * parameters["T_i"] / parameters["K_W"]
    expected = INITIAL["mu"] * INITIAL["c"] * INITIAL["T_i"] / INITIAL["K_W"]
    assert friction == pytest.approx(expected, rel=0.2)


def test_a_worn_drive_keeps_its_stiffness_but_not_its_parameters() -> None:
    """The curve is met within some 5 %; the answer hangs on where the points are read."""
    found = identify_record(loop(POST_TEST, 2), Drive())
    values = {name: np.array([value]) for name, value in found.parameters.items()}
    truth = {name: np.array([value]) for name, value in POST_TEST.items()}
    got = secant_stiffness(60.0, values, ALPHA)[0]
    assert got == pytest.approx(secant_stiffness(60.0, truth, ALPHA)[0], rel=0.05)
    low, high = found.other_choices["T_T"]
    assert high > 1.5 * low
    assert found.choices_solved <= found.choices_tried
    assert all(low <= found.parameters[n] <= high for n, (low, high) in found.other_choices.items())


@pytest.mark.parametrize("seed", [2, 7])
def test_no_stiffness_runs_to_infinity(seed: int) -> None:
    """Points that would need a rigid part are no answer, and are not counted as one."""
    found = identify_record(loop(POST_TEST, seed), Drive())
    assert found.other_choices["K_F"][1] < 1e8
    assert found.other_choices["b"][1] < 1e8


def test_a_one_sided_record_is_refused_with_a_way_out() -> None:
    torque = np.concatenate([np.linspace(0, 60, 80), np.linspace(59, 0, 80)])
    values = {name: np.asarray(value) for name, value in POST_TEST.items()}
    angle = predict(torque, values, ALPHA)
    angle += 1e-5 * np.random.default_rng(0).standard_normal(torque.size)
    record = Loop(torque, angle, source="half.csv")
    with pytest.raises(BadInputError, match=r"half\.csv.*two-sided.*--method posterior"):
        identify_record(record, Drive())
