"""Other models against their own printed formulas and hand calculations."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.physics.course import Course
from hdprog.physics.other_models import BY_ID
from hdprog.physics.other_models.base import Setting
from hdprog.physics.other_models.ideal_three_port import (
    gear_ratio,
    port_torques,
    wave_generator_angle,
)
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

TOP = 60.0


def cycle() -> Course:
    """Three times to ± 60 Nm; the last cycle is steady."""
    legs = [np.linspace(0, TOP, 121)]
    for _ in range(3):
        legs += [np.linspace(TOP, -TOP, 241)[1:], np.linspace(-TOP, TOP, 241)[1:]]
    torque = np.concatenate(legs)
    return record_course(Loop(torque, torque / 1.5e4), TorquePath.exact(torque), 0.0)


COURSE = cycle()
SETTING = Setting.of(COURSE)


def column(**values: float) -> dict[str, FloatArray]:
    return {name: np.array([[value]]) for name, value in values.items()}


def last_cycle(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angle on the last falling and the last rising branch, both by rising torque."""
    return angle[0, -481:-240][::-1], angle[0, -241:]


def test_three_ports_keep_power_and_the_usual_arrangement() -> None:
    ratio = gear_ratio(160, 162)
    assert ratio == 80.0
    moves = np.array([[0.3, -0.1], [0.2, 0.7]])
    wave_generator, circular_spline = port_torques(np.array(10.0), ratio)
    power_in = wave_generator * wave_generator_angle(moves[0], moves[1], ratio)
    np.testing.assert_allclose(power_in, circular_spline * moves[0] + 10.0 * moves[1])
    # Circular spline held: eqs 4 and 5.
    assert wave_generator_angle(np.zeros(1), np.array([0.01]), ratio)[0] == pytest.approx(-0.8)
    assert wave_generator == pytest.approx(-10.0 / 80.0)


def test_catalogue_pieces_add_up() -> None:
    setting = Setting(SETTING.scales, -TOP, TOP, (14.0, 48.0))
    values = column(K1=3.1e4, K2=5.0e4, K3=5.7e4)
    found = BY_ID["catalogue_piecewise"].stiffness_curve(
        np.array([-14.0, 0.0, 14.0, 48.0, 60.0]), values, setting
    )
    assert found is not None
    first, second = 14 / 3.1e4, 14 / 3.1e4 + 34 / 5.0e4
    expected = [-first, 0.0, first, second, second + 12 / 5.7e4]
    np.testing.assert_allclose(found[0], expected, rtol=1e-12)


def test_the_cubic_gives_back_its_torque() -> None:
    a1, a3 = 1.2e4, 3.0e8
    angle = BY_ID["cubic"].angle(COURSE, column(a1=a1, a3=a3), SETTING)[0]
    within = np.abs(angle) < 1.1 * SETTING.angle
    torque = a1 * angle + a3 * angle**3
    np.testing.assert_allclose(torque[within], COURSE.path.torque[within], atol=1e-9)
    assert within.mean() > 0.9


def test_dhaouadi_runs_through_the_printed_branches() -> None:
    """(A1) and (A2) with exp(−2βQ) in the denominator, on the steady cycle."""
    b, A, beta = (1.3e4, 4.0e7, 3.0e11), 5.0e3, 3.0e3
    values = column(b1=b[0], b2=b[1], b3=b[2], A=A, beta=beta, initial_state=0.0)
    falling, rising = last_cycle(BY_ID["dhaouadi"].angle(COURSE, values, SETTING))
    Q = rising[-1]
    torque = np.linspace(-TOP, TOP, 241)
    for angle, sign in ((rising, 1.0), (falling, -1.0)):
        elastic = b[0] * angle + b[1] * angle**3 + b[2] * angle**5
        decay = np.exp(-beta * (Q + sign * angle)) / (1 + np.exp(-2 * beta * Q))
        np.testing.assert_allclose(elastic - sign * A / beta * (-1 + 2 * decay), torque, atol=1e-4)


def test_zhang_runs_through_the_printed_branches() -> None:
    values = column(K_F0=2e4, C_F=0.01, K_w0=3e4, C_w=0.02, F_f=2.0, initial_state=0.5)
    falling, rising = last_cycle(BY_ID["zhang"].angle(COURSE, values, SETTING))
    torque = np.linspace(-TOP, TOP, 241)
    for angle, sign in ((rising, 1.0), (falling, -1.0)):
        through = torque - sign * 2.0
        part = np.sign(through) * (1 - np.exp(-0.02 * np.abs(through))) / (0.02 * 3e4)
        expected = np.arctan(0.01 * torque) / (0.01 * 2e4) + part
        slid = sign * torque > -TOP + 4.0
        np.testing.assert_allclose(angle[slid], expected[slid], rtol=1e-12, atol=1e-15)


def test_seyfferth_has_its_friction_far_from_reversals() -> None:
    values = column(a1=1.5e4, a3=1e8, T_c=1.5, delta=1e-4, initial_state=0.0)
    falling, rising = last_cycle(BY_ID["seyfferth"].angle(COURSE, values, SETTING))
    for angle, sign in ((rising, 1.0), (falling, -1.0)):
        elastic = 1.5e4 * angle + 1e8 * angle**3
        middle = slice(80, 160)
        np.testing.assert_allclose(
            elastic[middle] + sign * 1.5, np.linspace(-TOP, TOP, 241)[middle], atol=1e-8
        )


def test_structural_damping_widens_the_loop_with_load() -> None:
    values = column(a1=1.5e4, a3=0.0, D=2.0, p=1.0, initial_state=0.5)
    falling, rising = last_cycle(BY_ID["taghirad"].angle(COURSE, values, SETTING))
    torque = np.linspace(-TOP, TOP, 241)
    damping = 2.0 / SETTING.angle  # p = 1: a stiffness more when loading, less when unloading
    loading = torque > 0
    np.testing.assert_allclose(rising[loading], torque[loading] / (1.5e4 + damping), atol=2e-8)
    slid = loading & (torque < 50)
    np.testing.assert_allclose(falling[slid], torque[slid] / (1.5e4 - damping), atol=2e-8)
    assert abs(falling[120] - rising[120]) < 1e-7


def test_one_maxwell_slider_is_a_play() -> None:
    model = BY_ID["maxwell_slip"]
    names = [one.name for one in model.parameters(SETTING)]
    values = column(**dict.fromkeys(names, 0.0))
    values["w_6"] = np.array([[1e-5]])
    limit = 0.9 * (0.005 / 0.9) ** (4 / 9) * TOP
    falling, rising = last_cycle(model.angle(COURSE, values, SETTING))
    assert (falling - rising)[120] == pytest.approx(2 * limit * 1e-5, rel=1e-9)
    assert rising[-1] == pytest.approx((TOP - limit) * 1e-5, rel=1e-9)


def test_a_preisach_cell_of_relays_goes_up_and_down_where_it_lies() -> None:
    model = BY_ID["preisach"]
    parameters = model.parameters(SETTING)
    values = column(**dict.fromkeys([one.name for one in parameters], 0.0))
    values["w_5_2"] = np.array([[1e-3]])  # up between the edges 4, 5, down between 1, 2
    falling, rising = last_cycle(model.angle(COURSE, values, SETTING))
    edges = TOP * np.sign(np.linspace(-1, 1, 7)) * np.abs(np.linspace(-1, 1, 7)) ** 1.4
    torque = np.linspace(-TOP, TOP, 241)
    np.testing.assert_allclose(rising[torque < edges[4]], 0.0, atol=1e-15)
    np.testing.assert_allclose(rising[torque > edges[5]], 1e-3, rtol=1e-12)
    np.testing.assert_allclose(falling[torque < edges[1]], 0.0, atol=1e-15)
    np.testing.assert_allclose(falling[torque > edges[2]], 1e-3, rtol=1e-12)


def test_a_minor_loop_of_relays_closes() -> None:
    """Return-point memory: back at the reversal's torque the relays are as they were."""
    corners = [0.0, 50.0, 11.3, 37.7, 11.3, 50.0, 0.0]
    torque = np.concatenate([np.linspace(a, b, 80) for a, b in pairwise(corners)])
    course = record_course(Loop(torque, torque / 1e4), TorquePath.exact(torque), 0.0)
    model = BY_ID["preisach"]
    setting = Setting.of(course)
    names = [one.name for one in model.parameters(setting)]
    rng = np.random.default_rng(2)
    values = {name: np.abs(rng.standard_normal((1, 1))) for name in names}
    angle = model.angle(course, values, setting)[0]
    assert angle[159] == pytest.approx(angle[319], rel=1e-9)


def test_tuttle_without_motion_effects_is_the_cubic() -> None:
    time = np.arange(COURSE.path.torque.size) * 0.1
    loop = Loop(COURSE.path.torque, COURSE.path.torque / 1.5e4, time=time, output_angle=0.2 * time)
    course = record_course(loop, TorquePath.exact(loop.torque), 0.0)
    setting = Setting.of(course)
    model = BY_ID["tuttle"]
    values = column(**dict.fromkeys([one.name for one in model.parameters(setting)], 0.0))
    values |= column(a1=1.2e4, a3=2e8, Omega=1.0, delta=1.0, n_1=3.0, ratio_2=2.0, ratio_3=3.0)
    spring = BY_ID["cubic"].angle(course, column(a1=1.2e4, a3=2e8), setting)
    np.testing.assert_allclose(model.angle(course, values, setting), spring, atol=1e-15)
    # Constant speed of 0.2 rad/s: Coulomb friction takes its share of the torque; a line adds.
    values |= column(F_c=1.0, F_v=5.0, sine_1=1e-4)
    moved = model.angle(course, values, setting)
    shifted = course.path.torque - 2.0
    expected = np.interp(shifted, *sorted_pairs(course.path.torque, spring[0]))
    expected = expected + 1e-4 * np.sin(3.0 * (loop.output_angle - loop.output_angle.mean()))
    inner = np.abs(course.path.torque) < 55
    np.testing.assert_allclose(moved[0, inner], expected[inner], atol=2e-7)


def sorted_pairs(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    order = np.unique(x, return_index=True)[1]
    return x[order], y[order]
