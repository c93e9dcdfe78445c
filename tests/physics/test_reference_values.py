"""The drive model against the table of reference values, to the printed digits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hdprog.physics.drive_model import predict, slip
from hdprog.physics.figures import Operation, hysteresis_width
from hdprog.physics.torque_path import TorquePath
from tests.physics.table2 import INITIAL, POST_TEST

AT = (0, 10, 30, 50, 100)
REFERENCE = {
    ("initial", "continuum", "loading"): (
        -6.106267e-05,
        1.785168e-04,
        6.310166e-04,
        1.089414e-03,
        2.235409e-03,
    ),
    ("initial", "continuum", "unloading"): (
        6.106267e-05,
        2.900685e-04,
        7.480803e-04,
        1.206092e-03,
        2.235409e-03,
    ),
    ("post-test", "continuum", "loading"): (
        -4.348585e-05,
        9.105894e-04,
        1.732874e-03,
        2.385559e-03,
        4.000364e-03,
    ),
    ("post-test", "continuum", "unloading"): (
        4.348585e-05,
        9.879140e-04,
        1.816274e-03,
        2.469014e-03,
        4.000364e-03,
    ),
    ("post-test", "as_printed", "loading"): (
        -4.348585e-05,
        8.068909e-04,
        1.641943e-03,
        2.294628e-03,
        3.909433e-03,
    ),
}
STATES = {"initial": INITIAL, "post-test": POST_TEST}


def steady_cycle(top: float, steps: int = 100) -> np.ndarray:
    """0 → +top → −top → +top → 0, `steps` a quarter, so that the last rise and fall are steady."""
    quarter = np.linspace(0, top, steps + 1)
    return np.concatenate(
        [quarter, quarter[-2::-1], -quarter[1:], -quarter[-2::-1], quarter[1:], quarter[-2::-1]]
    )


@pytest.mark.parametrize(("state", "mesh", "branch"), REFERENCE)
def test_printed_digits(state: str, mesh: str, branch: str) -> None:
    torque = steady_cycle(100.0)
    angle = predict(torque, STATES[state], tooth_mesh=mesh)  # type: ignore[arg-type]
    rising, falling = angle[400:501], angle[500:][::-1]
    found = (rising if branch == "loading" else falling)[list(AT)]
    # Half a unit of the last printed digit.
    np.testing.assert_allclose(found, REFERENCE[state, mesh, branch], rtol=5e-7)


@pytest.mark.parametrize(("state", "width"), [("initial", 6.993e-5), ("post-test", 4.969e-5)])
def test_width_at_20_degrees(state: str, width: float) -> None:
    operation = Operation(math.radians(20), 100.0, 63.0)
    assert hysteresis_width(STATES[state], operation)[0] == pytest.approx(width, rel=1e-4)


def test_the_staircase_and_the_integral_differ_as_stated() -> None:
    torque = steady_cycle(100.0)
    forms = [
        predict(torque, POST_TEST, tooth_mesh=mesh)[500] for mesh in ("continuum", "as_printed")
    ]
    assert forms[0] - forms[1] == pytest.approx(9.1e-5, abs=0.05e-5)


def printed_slip(torque: float, state: dict[str, float], branch: str, top: float) -> float:
    """Eqs 26 and 28 written out case by case."""
    s, k = math.sin(math.radians(30)), math.cos(math.radians(30))
    mu, stiffness = state["mu"], state["K_W"]

    def preload(at: float) -> float:
        return max(state["c"] * (at - state["T_i"]), 0.0)

    t0 = preload(torque)
    if branch == "loading":
        if torque <= t0 * mu / (s + mu * k):
            return -(mu * (t0 - torque * k) - torque * s) / (stiffness * (k - mu * s))
        if torque <= t0 * mu / (s - mu * k):
            return 0.0
        return (torque * (s - mu * k) - t0 * mu) / (stiffness * (k + mu * s))
    largest = (top * (s - mu * k) - preload(top) * mu) / (stiffness * (k + mu * s))
    threshold = (stiffness * largest * (k - mu * s) - t0 * mu) / (s + mu * k)
    if torque >= threshold:
        return largest
    return (torque * (s + mu * k) + t0 * mu) / (stiffness * (k - mu * s))


@pytest.mark.parametrize("state", STATES)
def test_play_operator_is_eqs_26_and_28_on_a_symmetric_cycle(state: str) -> None:
    torque = steady_cycle(100.0)
    values = {name: np.array([value]) for name, value in STATES[state].items()}
    travelled = slip(TorquePath.exact(torque), values, math.radians(30))[0]
    for offset in range(101):
        rising = printed_slip(float(offset), STATES[state], "loading", 100.0)
        falling = printed_slip(float(offset), STATES[state], "unloading", 100.0)
        assert travelled[400 + offset] == pytest.approx(rising, rel=1e-9, abs=1e-15)
        assert travelled[600 - offset] == pytest.approx(falling, rel=1e-9, abs=1e-15)
