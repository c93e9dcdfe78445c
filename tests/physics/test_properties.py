"""Properties of the drive model for any parameters inside the hard support."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hdprog.errors import BadInputError
from hdprog.physics.drive_model import predict, slip_envelope, torsion_angle
from hdprog.physics.elastic import elastic_angle
from hdprog.physics.figures import (
    FigureRequest,
    Operation,
    figures,
    hysteresis_loss,
    local_stiffness,
    stiffness_curve,
)
from hdprog.physics.parameters import BY_NAME, NAMES, in_support
from hdprog.physics.torque_path import TorquePath
from tests.physics.table2 import POST_TEST

ALPHA = math.radians(30)


def log_floats(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(math.log(low), math.log(high)).map(math.exp)


STATES = st.fixed_dictionaries(
    {
        "K_F": log_floats(1e3, 1e6),
        "K_W": log_floats(1e3, 1e6),
        "a": st.one_of(st.just(0.0), log_floats(1e-6, 1e5)),
        "b": log_floats(1e3, 1e6),
        "T_T": st.one_of(st.just(0.0), st.floats(0.01, 60.0)),
        "c": log_floats(0.1, 5.0).map(lambda value: -value),
        "T_i": st.floats(0.0, 200.0),
        "mu": st.floats(0.001, 0.5),
    }
).filter(lambda state: bool(in_support({k: np.array(v) for k, v in state.items()}, ALPHA)))
HISTORIES = st.lists(st.floats(-120.0, 120.0), min_size=2, max_size=8)


def history(turns: list[float]) -> np.ndarray:
    return np.concatenate(
        [np.linspace(a, b, 23, endpoint=False) for a, b in itertools.pairwise(turns)]
        + [[turns[-1]]]
    )


@given(STATES, HISTORIES)
@settings(max_examples=60, deadline=None)
def test_odd_symmetry(state: dict[str, float], turns: list[float]) -> None:
    torque = history(turns)
    np.testing.assert_allclose(predict(-torque, state), -predict(torque, state), atol=1e-14)


@given(STATES)
@settings(max_examples=60, deadline=None)
def test_envelopes_are_monotone_and_ordered(state: dict[str, float]) -> None:
    torque = np.linspace(-150, 150, 601)
    lower = slip_envelope(torque, state, ALPHA)[0]
    upper = -slip_envelope(-torque, state, ALPHA)[0]
    assert (np.diff(lower) >= -1e-15).all()
    assert (np.diff(upper) >= -1e-15).all()
    assert (lower <= upper + 1e-15).all()


@given(STATES, HISTORIES, st.floats(-1e-3, 1e-3))
@settings(max_examples=60, deadline=None)
def test_fast_slip_equals_the_sample_by_sample_operator(
    state: dict[str, float], turns: list[float], initial: float
) -> None:
    torque = history(turns)
    lower = slip_envelope(torque, state, ALPHA)[0]
    upper = -slip_envelope(-torque, state, ALPHA)[0]
    y, expected = initial, np.empty(torque.size)
    for index in range(torque.size):
        y = min(max(y, lower[index]), upper[index])
        expected[index] = y
    elastic = elastic_angle(TorquePath.exact(torque), {k: np.array(v) for k, v in state.items()})[0]
    found = predict(torque, state, initial_slip=initial)
    np.testing.assert_allclose(found, elastic + math.tan(ALPHA) * expected, atol=1e-13)


def test_an_initial_slip_that_is_no_number_is_refused() -> None:
    with pytest.raises(BadInputError, match="initial_slip that is no number"):
        predict(np.array([0.0, 1.0]), POST_TEST, initial_slip=math.nan)
    envelope = predict(np.array([0.0]), POST_TEST, initial_slip=math.inf)  # clipped like any other
    assert envelope == pytest.approx([4.348585e-05], rel=1e-6)


@given(STATES, st.floats(5, 100), st.floats(0.1, 0.9), st.floats(0.1, 0.9))
@settings(max_examples=40, deadline=None)
def test_minor_loops_close(state: dict[str, float], top: float, start: float, depth: float) -> None:
    high = top * start
    low = high * (1 - depth) - top * 0.1
    torque = history([0, top, high, low, high, low, high])
    angle = predict(torque, state)
    # The first minor cycle may still ratchet; the second returns to where it began.
    assert angle[-1] == pytest.approx(angle[-1 - 2 * 23], abs=1e-13)


@given(STATES)
@settings(max_examples=40, deadline=None)
def test_mesh_tends_to_its_limit_as_a_vanishes(state: dict[str, float]) -> None:
    torque = np.linspace(-100, 100, 41)
    limit = predict(torque, {**state, "a": 0.0})
    for a in (1e-12, 1e-9, 1e-7):
        near = predict(torque, {**state, "a": a})
        np.testing.assert_allclose(near, limit, atol=1e-8 * np.abs(limit).max())


@given(STATES, st.floats(1, 100))
@settings(max_examples=60, deadline=None)
def test_local_stiffness_is_the_slope_of_the_curve(state: dict[str, float], at: float) -> None:
    step = 1e-5
    if abs(at - state["T_T"]) < 2 * step:
        return
    angle = stiffness_curve(np.array([at - step, at + step]), state, ALPHA)[0]
    slope = 2 * step / (angle[1] - angle[0])
    # The difference quotient loses digits; its rounding error is about 1e-16 * angle / step.
    assert local_stiffness(at, state, ALPHA)[0] == pytest.approx(slope, rel=1e-5)


@given(STATES)
@settings(max_examples=40, deadline=None)
def test_loss_is_never_negative_and_draws_do_not_mix(state: dict[str, float]) -> None:
    operation = Operation(ALPHA, 63.0, 63.0, (14.0, 48.0))
    assert hysteresis_loss(state, operation)[0] >= 0
    both = {name: np.array([POST_TEST[name], state[name]]) for name in NAMES}
    requests = [
        FigureRequest("lost_motion_arcmin"),
        FigureRequest("K2_Nm_per_rad"),
        FigureRequest("secant_stiffness_Nm_per_rad", 14.0),
    ]
    together = figures(requests, both, operation)
    alone = figures(requests, {name: np.array([state[name]]) for name in NAMES}, operation)
    for key, values in together.items():
        assert values[1] == pytest.approx(alone[key][0], rel=1e-12)


def test_block_variance_corrects_the_average_of_a_curve() -> None:
    fine = np.linspace(2.0, 6.0, 4001)
    block = TorquePath(
        np.array([fine.mean()]), np.array([0]), np.array([True]), np.array([fine.var()])
    )
    state = {name: np.array([value]) for name, value in POST_TEST.items()}
    exact = elastic_angle(TorquePath.exact(fine), state).mean()
    plain = elastic_angle(TorquePath.exact(np.array([fine.mean()])), state)[0, 0]
    corrected = elastic_angle(block, state)[0, 0]
    assert abs(corrected - exact) < 0.1 * abs(plain - exact)


@pytest.mark.parametrize("b", [5.0, 5729.6])
@pytest.mark.parametrize(("a", "T_T"), [(1833.5, 30.0), (1833.5, 0.2), (1e-8, 30.0)])
@pytest.mark.parametrize("middle", [0.0, -0.3, 0.55, 0.9])
def test_a_block_around_zero_torque_has_its_exact_average(
    middle: float, a: float, T_T: float, b: float
) -> None:
    """Of teeth as soft as play, too: curvature times variance threw such a block far off."""
    half = 0.5
    inside = np.linspace(middle - half, middle + half, 100_001)
    state = {
        name: np.array([value])
        for name, value in (POST_TEST | {"a": a, "b": b, "T_T": T_T}).items()
    }
    angle = elastic_angle(TorquePath(inside, np.array([0]), np.array([True])), state)[0]
    exact = np.trapezoid(angle, inside) / (2 * half)
    block = TorquePath(np.array([middle]), np.array([0]), np.array([True]), np.array([half**2 / 3]))
    found = elastic_angle(block, state)[0, 0]
    assert found == pytest.approx(exact, rel=1e-6, abs=1e-12)


def test_transforms_invert() -> None:
    for name, parameter in BY_NAME.items():
        values = np.array([0.01, 1.0, 300.0]) * (-1 if name == "c" else 1)
        there = parameter.to_coordinate(values, 10.0)
        np.testing.assert_allclose(parameter.from_coordinate(there, 10.0), values, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"K_F": -1.0}, "support"),
        ({"mu": 0.7}, "support"),
        ({"c": 0.5}, "support"),
        ({"a": math.inf}, "a and T_T finite"),  # its angles were NaN
        ({"a": 0.0, "T_T": math.inf}, "a and T_T finite"),  # and so were these
    ],
)
def test_predict_refuses_what_is_outside_the_support(change: dict[str, float], word: str) -> None:
    with pytest.raises(BadInputError, match=word):
        predict(np.array([0.0, 1.0]), {**POST_TEST, **change})


def test_predict_refuses_missing_parameters_and_bad_torque() -> None:
    with pytest.raises(BadInputError, match="K_W"):
        predict(np.array([0.0, 1.0]), {k: v for k, v in POST_TEST.items() if k != "K_W"})
    with pytest.raises(BadInputError, match="finite"):
        predict(np.array([0.0, np.nan]), POST_TEST)
    # What lies below the mask was taken for a torque: a filled gap of a netCDF file is 1e20.
    with pytest.raises(BadInputError, match="finite"):
        predict(np.ma.masked_array([0.0, 1e20], [False, True]), POST_TEST)
    open_mask = np.ma.masked_array([0.0, 1.0], [False, False])
    assert np.isfinite(predict(open_mask, POST_TEST)).all()


def test_shapes() -> None:
    torque = np.linspace(0, 50, 7)
    assert predict(torque, POST_TEST).shape == (7,)
    many = {name: np.full(3, value) for name, value in POST_TEST.items()}
    assert predict(torque, many).shape == (3, 7)
    path = TorquePath.exact(torque)
    assert torsion_angle(path, many, ALPHA).shape == (3, 7)


def test_predict_takes_numbers_beside_arrays_of_draws() -> None:
    torque = np.array([0.0, 40.0, 63.0, 10.0, -63.0, 5.0])
    mu, slips = np.array([0.05, 0.076]), np.array([0.0, 1e-4])
    one_by_one = [predict(torque, {**POST_TEST, "mu": float(value)}) for value in mu]
    np.testing.assert_array_equal(predict(torque, {**POST_TEST, "mu": mu}), one_by_one)
    started = [predict(torque, POST_TEST, initial_slip=float(slip)) for slip in slips]
    np.testing.assert_array_equal(predict(torque, POST_TEST, initial_slip=slips), started)
    # As a posterior has them: ensemble, walker, step.
    stored = {**POST_TEST, "mu": mu.reshape(1, 2, 1)}
    np.testing.assert_array_equal(predict(torque, stored), one_by_one)
    with pytest.raises(BadInputError, match=r"mu of shape \(2,\), initial_slip of shape \(3,\)"):
        predict(torque, {**POST_TEST, "mu": mu}, initial_slip=np.zeros(3))
    with pytest.raises(BadInputError, match=r"support in draw 2: .* mu=-0\.05;"):
        predict(torque, {**POST_TEST, "mu": [0.05, -0.05]})


@pytest.mark.parametrize("alpha", [30, 45, 20.0, 0.0, -0.5, math.nan, None, "pi/6"])
def test_predict_refuses_a_tooth_angle_that_is_not_in_radians(alpha: Any) -> None:
    """45 and 20 degrees, taken for radians, have a sine and a cosine that pass for an angle's."""
    with pytest.raises(BadInputError, match=r"argument alpha: .* in rad"):
        predict(np.array([0.0, 1.0]), POST_TEST, alpha=alpha)


def test_predict_says_what_is_no_number() -> None:
    wrong: Any
    for wrong, name in (("soft", "mu of type str"), ({}, "mu of type dict")):
        with pytest.raises(BadInputError, match=name):
            predict(np.array([0.0, 1.0]), {**POST_TEST, "mu": wrong})
    with pytest.raises(BadInputError, match=r"torque: found .* not all numbers"):
        predict(["much"], POST_TEST)  # type: ignore[arg-type]
    with pytest.raises(BadInputError, match="without K_F, K_W"):
        predict(np.array([0.0, 1.0]), None)  # type: ignore[arg-type]
