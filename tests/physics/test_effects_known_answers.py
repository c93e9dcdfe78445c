"""Every effect against what its formula gives where that can be written down or stepped through."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ndtr

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.physics.course import Course
from hdprog.physics.drive_model import predict, slip, slip_envelope, torsion_angle
from hdprog.physics.effects import BY_ID
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.first_order import follow, follow_two, resolved
from hdprog.physics.lag_elements import exponential_lag, jenkins
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.torque_path import TorquePath
from hdprog.physics.warm_up import WarmUp, warm_up
from tests.physics.table2 import POST_TEST

ALPHA = math.radians(30)
DRIVE: Parameters = {name: np.array([value]) for name, value in POST_TEST.items()}


def course_of(
    torque: FloatArray,
    time: FloatArray | None = None,
    temperature: FloatArray | None = None,
    output_angle: FloatArray | None = None,
) -> Course:
    loop = Loop(torque, torque / 1.5e4, time, temperature, output_angle)
    return record_course(loop, TorquePath.exact(torque), 0.0)


def zigzag(*corners: float, samples: int = 40) -> FloatArray:
    """Straight from corner to corner, `samples` a stretch."""
    steps = np.linspace(0, len(corners) - 1, (len(corners) - 1) * samples + 1)
    return np.interp(steps, np.arange(len(corners)), corners)


def added(
    name: str, course: Course, angle: FloatArray | None = None, **values: float
) -> FloatArray:
    """What an effect of these physical values adds to the angle, (samples,)."""
    columns = {key: np.array([[value]]) for key, value in values.items()}
    start = np.zeros((1, course.path.torque.size)) if angle is None else angle[None, :]
    found = BY_ID[name].evaluate(course, columns, start)
    return np.broadcast_to(found, start.shape)[0]


def whole_angle(name: str, course: Course, **values: float) -> FloatArray:
    """Angle of the worn drive with an effect of these physical values, (samples,)."""
    columns = {name: {key: np.array([[value]]) for key, value in values.items()}}
    effects = EffectSet((BY_ID[name],), course.scales)
    return effects.angle(course, DRIVE, columns, ALPHA, np.array([0.5]))[0]


def plain_angle(torque: FloatArray, parameters: Parameters = DRIVE) -> FloatArray:
    path = TorquePath.exact(torque)
    return torsion_angle(path, parameters, ALPHA, initial_fraction=np.array([0.5]))[0]


def random_walk(seed: int) -> FloatArray:
    """A torque history with many reversals of every size."""
    rng = np.random.default_rng(seed)
    return zigzag(*(60.0 * rng.uniform(-1, 1, 14)), samples=17)


def test_torque_offset_is_the_drive_at_the_shifted_torque() -> None:
    torque = zigzag(0, 60, -60, 30, -10)
    found = whole_angle("torque_offset", course_of(torque), zero_torque=1.7)
    np.testing.assert_allclose(found, plain_angle(torque - 1.7), rtol=0, atol=1e-15)


def test_backlash_is_a_step_of_its_height() -> None:
    torque = np.concatenate([zigzag(0, 60, -60), [-0.5, 0.0, 0.5]])
    found = added("backlash", course_of(torque), play=1e-4, width=0.5, centre=0.0)
    assert found[torque == 60.0][0] - found[torque == -60.0][0] == pytest.approx(1e-4, rel=1e-12)
    inside = [-0.5e-4 * math.tanh(1.0), 0.0, 0.5e-4 * math.tanh(1.0)]
    np.testing.assert_allclose(found[-3:], inside, atol=1e-19)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("backlash", {"play": 3e-4, "width": 0.7, "centre": 0.0}),
        ("backlash", {"play": 3e-4, "width": 0.7, "centre": 6.0}),
        ("cup_hardening", {"hardening": 2e-4, "exponent": 2.6}),
        ("tooth_damage", {"height": 1e-4, "centre": 20.0, "width": 3.0}),
    ],
)
def test_what_sits_at_a_torque_sits_at_the_true_one(name: str, values: dict[str, float]) -> None:
    reading, zero = zigzag(0.0, 60.0, -60.0, 60.0), 1.5
    course, true = course_of(reading), course_of(reading - zero)
    true = replace(true, scales=course.scales)
    own = {key: np.full((1, 1), value) for key, value in values.items()}
    both = EffectSet((BY_ID["torque_offset"], BY_ID[name]), course.scales)
    drive = {key: np.asarray(value) for key, value in DRIVE.items()}
    told = {"torque_offset": {"zero_torque": np.full((1, 1), zero)}, name: own}
    half = np.full(1, 0.5)
    found = both.angle(course, drive, told, ALPHA, half)
    alone = EffectSet((BY_ID[name],), course.scales)
    wanted = alone.angle(true, drive, {name: own}, ALPHA, half)
    np.testing.assert_allclose(found, wanted, atol=1e-12)
    held = both.held(course, told)
    np.testing.assert_allclose(held.angle(drive, ALPHA, half), wanted, atol=1e-12)


def test_asymmetry_mirrors_a_drive_with_its_own_parameters() -> None:
    torque = zigzag(0, 60, -60, 60, 0)
    course = course_of(torque)
    found = whole_angle("asymmetry", course, log_stiffness_ratio=0.1, log_friction_ratio=-0.3)
    changed = {name: DRIVE[name] * math.exp(0.1) for name in ("K_F", "K_W", "a", "b")}
    other = {**DRIVE, **changed, "mu": DRIVE["mu"] * math.exp(-0.3)}
    # From the rise behind −60 Nm on, each side is on its own steady branches.
    falling, rising = slice(41, 121), slice(121, None)
    for part, positive in itertools.product((falling, rising), (True, False)):
        side = (torque[part] > 0) if positive else (torque[part] < 0)
        wanted = plain_angle(torque) if positive else plain_angle(torque, other)
        np.testing.assert_allclose(found[part][side], wanted[part][side], rtol=0, atol=1e-12)
    equal = whole_angle("asymmetry", course, log_stiffness_ratio=0.0, log_friction_ratio=0.0)
    np.testing.assert_allclose(equal, plain_angle(torque), rtol=0, atol=1e-15)


def test_asymmetry_of_a_torque_of_one_sign() -> None:
    torque = zigzag(0, -60, -2)
    found = whole_angle(
        "asymmetry", course_of(torque), log_stiffness_ratio=0.2, log_friction_ratio=0.1
    )
    changed = {name: POST_TEST[name] * math.exp(0.2) for name in ("K_F", "K_W", "a", "b")}
    other = {**POST_TEST, **changed, "mu": POST_TEST["mu"] * math.exp(0.1)}
    np.testing.assert_allclose(found, -predict(-torque, other), rtol=0, atol=1e-12)


@pytest.mark.parametrize(("exponent", "half"), [(3.0, -1e-5), (2.0, -2e-5)])
def test_cup_hardening_is_an_odd_power(exponent: float, half: float) -> None:
    torque = np.array([0.0, 30.0, 60.0, -30.0, -60.0])
    found = added("cup_hardening", course_of(torque), hardening=-8e-5, exponent=exponent)
    np.testing.assert_allclose(found, [0, half, -8e-5, -half, 8e-5], atol=1e-19)


def stepped_jenkins(torque: FloatArray, limit: float, initial: float) -> FloatArray:
    state, states = initial, [initial]
    for step in np.diff(torque):
        state = min(max(state + step / limit, -1.0), 1.0)
        states.append(state)
    return np.array(states)


def stepped_lag(torque: FloatArray, length: float, initial: float) -> FloatArray:
    state, states = initial, [initial]
    for step in np.diff(torque):
        end = math.copysign(1.0, step)
        state = end - (end - state) * math.exp(-abs(step) / length)
        states.append(state)
    return np.array(states)


LIMITS = np.array([[0.7], [9.0], [45.0], [300.0]])
STATES = np.array([[-1.0], [0.3], [0.9], [0.0]])


@pytest.mark.parametrize("seed", range(3))
def test_jenkins_elements_step_by_step(seed: int) -> None:
    torque = random_walk(seed)
    found = jenkins(course_of(torque), LIMITS, STATES)
    wanted = [
        stepped_jenkins(torque, *pair) for pair in zip(LIMITS[:, 0], STATES[:, 0], strict=True)
    ]
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_exponential_lag_step_by_step(seed: int) -> None:
    torque = random_walk(seed)
    course = course_of(torque)
    found, ends = exponential_lag(course, LIMITS, STATES)
    wanted = [stepped_lag(torque, *pair) for pair in zip(LIMITS[:, 0], STATES[:, 0], strict=True)]
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)
    np.testing.assert_allclose(ends, found[:, course.path.ends - 1], rtol=0, atol=1e-12)


def test_elements_know_reversals_that_fall_between_readings() -> None:
    """The denoised torque of a reversal counts, not that of the reading before it."""
    fine = zigzag(0, 30, -30, 10, samples=600)
    coarse = np.flatnonzero(np.arange(fine.size) % 7 == 3)
    whole = TorquePath.exact(fine)
    starts = np.searchsorted(coarse, whole.starts)
    path = TorquePath(fine[coarse], starts, whole.rising, reversal_torque=whole.reached)
    loop = Loop(fine[coarse], fine[coarse])
    state = jenkins(record_course(loop, path, 0.0), np.array([[20.0]]), np.array([[0.0]]))[0]
    # The first reading stands where the element starts: 0.15 Nm later than on the fine path.
    wanted = stepped_jenkins(fine, 20.0, -fine[coarse[0]] / 20.0)[coarse]
    np.testing.assert_allclose(state[starts[1] :], wanted[starts[1] :], rtol=0, atol=1e-12)


def test_coulomb_friction_widens_the_loop_by_a_constant() -> None:
    torque = zigzag(0, 60, -60, 60)
    found = added(
        "coulomb_friction", course_of(torque), width=4e-5, slip_torque=1.0, initial_state=0.0
    )
    fallen, risen = found[43:81], found[83:]
    np.testing.assert_allclose(fallen, 2e-5, atol=1e-19)
    np.testing.assert_allclose(risen, -2e-5, atol=1e-19)


def test_microslip_is_a_spread_of_jenkins_elements() -> None:
    torque = zigzag(0, 80, -80, 80, samples=160)
    course = course_of(torque)
    values = {"width": 4e-5, "slip_torque": 5.0, "spread": 0.7, "initial_state": 0.0}
    found = added("microslip", course, **values)
    # Both ends are far behind every element's limit: the whole width, from either side.
    assert found[160] == pytest.approx(-2e-5, rel=1e-12)
    assert found[320] == pytest.approx(2e-5, rel=1e-12)
    rise = found[160:321]
    assert (np.diff(rise) >= 0).all()
    # Rounded: steepest behind the reversal, and less steep from element to element.
    assert (np.diff(rise, 2) <= 1e-19).all()
    slopes = np.unique(np.diff(rise).round(18))
    assert slopes.size > 4
    # Masing's rule: half the travel and half the stroke from the virgin curve of rest.
    virgin = np.interp(0.5 * (80 - torque[160:321]), torque[:161], -found[:161])
    np.testing.assert_allclose(rise + 2e-5, 2 * virgin, atol=2e-9)


@pytest.mark.parametrize("spread", [0.4, 0.7, 1.0])
def test_microslip_follows_the_log_normal_spread_it_states(spread: float) -> None:
    """The virgin curve is E[min(T, L)]/E[L] over the slip limits L, in closed form."""
    torque, median = zigzag(0, 80, 79, samples=400), 5.0
    found = added(
        "microslip",
        course_of(torque),
        width=2.0,
        slip_torque=median,
        spread=spread,
        initial_state=0.0,
    )
    reached = torque[1:401]
    at = np.log(reached / median) / spread
    slipped = ndtr(at - spread)
    wanted = slipped + reached / median * np.exp(-0.5 * spread**2) * ndtr(-at)
    np.testing.assert_allclose(-found[1:401], wanted, atol=0.02)


def test_viscous_width_is_proportional_to_the_rate() -> None:
    time = np.cumsum([0.0, *np.repeat([0.5, 0.5, 1.0, 1.0, 0.25, 0.25], 40)])
    torque = zigzag(0, 60, -60, 0, 60, -60, 0)
    # Six stretches; the quickest goes at 12 Nm/s.
    course = course_of(torque, time)
    assert course.scales.rate == pytest.approx(12.0, rel=1e-9)
    found = added(
        "viscous_friction", course, width=6e-5, exponent=1.0, memory=0.5, initial_state=0.0
    )
    rates = np.diff(torque[::40]) / np.diff(time[::40])
    steady = found[39::40]
    np.testing.assert_allclose(steady, -3e-5 * rates / 12.0, atol=1e-11)


def test_viscous_friction_thins_with_its_exponent_and_starts_as_told() -> None:
    time = np.cumsum([0.0, *np.repeat([1.0, 0.25], 40)])
    torque = zigzag(0, 30, 0)
    course = course_of(torque, time)
    found = added(
        "viscous_friction", course, width=6e-5, exponent=0.5, memory=0.5, initial_state=-0.4
    )
    assert found[0] == pytest.approx(3e-5 * 0.4, rel=1e-9)
    assert found[39] == pytest.approx(-3e-5 * 0.25**0.5, rel=1e-4)


@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_stribeck_width_falls_with_the_rate(exponent: float) -> None:
    time = np.cumsum([0.0, *np.repeat([0.5, 0.5, 1.0, 1.0], 40)])
    torque = zigzag(0, 60, -60, 0, 60)
    found = added(
        "stribeck_friction",
        course_of(torque, time),
        width=6e-5,
        stribeck_rate=2.0,
        exponent=exponent,
        initial_state=0.0,
    )
    rates = np.diff(torque[::40]) / np.diff(time[::40])
    wanted = -3e-5 * np.sign(rates) * np.exp(-((np.abs(rates) / 2.0) ** exponent))
    np.testing.assert_allclose(found[39::40], wanted, rtol=1e-9)


def test_creep_is_the_step_response_and_its_recovery() -> None:
    """A torque put on within a microsecond, held for 60 s, and taken off."""
    grown = np.linspace(0, 60, 121)
    time = np.concatenate([[-1.0, -1e-6], grown, [60 + 1e-6], np.linspace(60.5, 120, 120)])
    torque = np.where((time >= 0) & (time <= 60), 50.0, 0.0)
    found = added(
        "creep",
        course_of(torque, time),
        amplitude=2e-5,
        time_constant=9.0,
        quick_share=0.5,
        left_before=0.0,
    )

    def response(after: FloatArray) -> FloatArray:
        quick, slow = -np.expm1(-after / 9.0), -np.expm1(-after / 72.0)
        return 1e-5 * (quick + slow)

    wanted = np.where(time > 0, response(np.maximum(time, 0)), 0.0)
    wanted -= np.where(time > 60, response(np.maximum(time - 60, 0)), 0.0)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-11)


def test_creep_forgets_what_earlier_loads_left() -> None:
    torque, time = zigzag(0, 50, 0), np.linspace(0, 200, 81)
    course = course_of(torque, time)
    with_rest = added(
        "creep", course, amplitude=2e-5, time_constant=5.0, quick_share=0.5, left_before=0.5
    )
    left = with_rest - added(
        "creep", course, amplitude=2e-5, time_constant=5.0, quick_share=0.5, left_before=0.0
    )
    np.testing.assert_allclose(left, 1e-5 * np.exp(-time / 40), atol=1e-18)


def test_creep_lags_a_slow_ramp_by_its_time_constants() -> None:
    torque, time = zigzag(0, 50, samples=400), np.linspace(0, 1000, 401)
    values = {"amplitude": 2e-5, "time_constant": 5.0, "quick_share": 0.5, "left_before": 0.0}
    found = added("creep", course_of(torque, time), **values)
    assert found[-1] == pytest.approx(2e-5 * (1 - 0.5 * 5 / 1000 - 0.5 * 40 / 1000), rel=1e-6)


WARMING_COURSES = {
    "evenly": lambda clock: 21 + 3 * clock,
    "as a warm-up": lambda clock: 21 + 3 * (1 - np.exp(-clock / 0.3)),
    "cooling": lambda clock: 27 - 4 * (1 - np.exp(-clock / 0.2)),
    "swinging": lambda clock: 21 + 2 * np.sin(14 * clock),
}


@pytest.mark.parametrize("name", WARMING_COURSES)
def test_thermal_drift_follows_the_recorded_temperature(name: str) -> None:
    torque, clock = zigzag(0, 50, -50, 0), np.linspace(0, 1, 121)
    course = course_of(torque, 90 * clock, WARMING_COURSES[name](clock))
    assert course.temperature is not None
    near = course.scales.warm_up
    assert near is not None
    values = {"drift": 4e-5, "softening": -1e-5, "temperature_gain": 1.0}
    found = added("thermal_drift", course, time_constant=near.constant, **values)
    wanted = (4e-5 - 1e-5 * torque / 50) * (course.temperature - near.level) / near.rise
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-18)


def test_a_temperature_that_warms_up_has_nothing_beside_its_warm_up() -> None:
    """So that nothing is left open between the two, whichever way it goes."""
    clock = np.linspace(0, 1, 1201)
    for rise, constant in ((3.0, 0.3), (-4.0, 0.1), (1.0, 2.0)):
        curve = warm_up(clock, np.array([[constant]]))[0]
        found = WarmUp.nearest(clock, 21 + rise * curve)
        assert found is not None
        assert found.rise == pytest.approx(rise, rel=0.02)
        assert found.constant == pytest.approx(constant, rel=0.08)
        assert np.abs(found.beside(clock, 21 + rise * curve)).max() < 0.02
    assert WarmUp.nearest(clock, 21 + 0.3 * clock) is None


@pytest.mark.parametrize("timed", [True, False])
def test_thermal_drift_without_a_telling_temperature_warms_up(timed: bool) -> None:
    torque = zigzag(0, 50, -50, 0)
    time = 90 * np.linspace(0, 1, 121) ** 2 + np.linspace(0, 1e-3, 121) if timed else None
    course = course_of(torque, time, np.linspace(21.0, 21.4, 121))
    found = added("thermal_drift", course, drift=4e-5, softening=0.0, time_constant=0.4)
    clock = np.linspace(0, 1, 121) if time is None else time / time[-1]
    wanted = 4e-5 * (1 - np.exp(-clock / 0.4)) / (1 - np.exp(-1 / 0.4))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-18)


def test_kinematic_error_is_periodic_in_the_output_position() -> None:
    # 16 readings a period of the first line, 90 lines a turn.
    output = 0.4 + np.arange(241) * 2 * np.pi / 90 / 16
    torque = zigzag(0, 50, -50, 0, samples=80)
    values = {"sine": 3e-5, "cosine": -1e-5, "second_sine": 0.0, "second_cosine": 2e-5}
    found = added(
        "kinematic_error",
        course_of(torque, None, None, output),
        lines=90.0,
        second_ratio=2.0,
        **values,
    )
    np.testing.assert_allclose(found[16:], found[:-16], rtol=0, atol=1e-16)
    assert np.abs(found[8:] - found[:-8]).max() > 5e-5
    phase = 90 * (output - output.mean())
    wanted = 3e-5 * np.sin(phase) - 1e-5 * np.cos(phase) + 2e-5 * np.cos(2 * phase)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-16)


def test_angle_ripple_is_periodic_in_the_angle_of_the_model() -> None:
    torque = zigzag(0, 50, -50, 0, samples=80)
    angle = plain_angle(torque)
    course = course_of(torque)
    values = {"sine": 1e-5, "cosine": 2e-5, "second_sine": -3e-6, "second_cosine": 4e-6}
    found = added("angle_ripple", course, angle, cycles=2000.0, **values)
    moved = added("angle_ripple", course, angle + 5e-4, cycles=2000.0, **values)
    half = added("angle_ripple", course, angle + 2.5e-4, cycles=2000.0, **values)
    np.testing.assert_allclose(moved, found, rtol=0, atol=1e-16)
    assert np.abs(half - found).max() > 2e-5
    phase = 2 * np.pi * 2000 * angle
    wanted = 1e-5 * np.sin(phase) + 2e-5 * np.cos(phase)
    wanted += -3e-6 * np.sin(2 * phase) + 4e-6 * np.cos(2 * phase)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-16)


@pytest.mark.parametrize("lag", [0.8, 8.0])
def test_torque_sensor_hysteresis_is_the_drive_at_the_lag_free_torque(lag: float) -> None:
    """The sensor's body lags behind the load, however much its reading differs from that."""
    true = zigzag(0, 60, -60, 20, -40, 0)
    reading = true - lag * stepped_lag(true, 25.0, -0.2)
    values = {"lag": lag, "travel": 25.0, "initial_state": -0.2}
    found = whole_angle("torque_sensor_hysteresis", course_of(reading), **values)
    np.testing.assert_allclose(found, plain_angle(true), rtol=0, atol=1e-14)


def test_the_lag_of_a_small_swing_is_small() -> None:
    """In the steady cycle to ± S the lag reaches tanh(S/T_l) and no more."""
    for swing in (5.0, 60.0):
        torque = zigzag(0, *(20 * [swing, -swing]))
        state = exponential_lag(course_of(torque), np.array([[25.0]]), np.zeros((1, 1)))[0][0]
        assert np.abs(state[-160:]).max() == pytest.approx(math.tanh(swing / 25.0), rel=1e-6)


def test_tooth_damage_is_the_same_bump_on_both_branches() -> None:
    torque = zigzag(0, 60, -60, 60)
    found = added("tooth_damage", course_of(torque), height=5e-5, centre=30.0, width=3.0)
    for at, part in ((30.0, 1.0), (33.0, math.exp(-0.5)), (24.0, math.exp(-2.0))):
        on_branches = found[np.abs(torque - at) < 1e-9]
        assert on_branches.size == 3
        np.testing.assert_allclose(on_branches, 5e-5 * part, rtol=1e-9)
    assert np.abs(found[torque < 0]).max() < 1e-20


@pytest.mark.parametrize("timed", [True, False])
def test_slip_jump_steps_once_and_for_good(timed: bool) -> None:
    torque, order = zigzag(0, 50, -50, 0), np.linspace(0, 1, 121)
    time = 90 * (order + order**2) / 2 if timed else None
    clock = order if time is None else time / time[-1]
    instant = float(clock[70])
    found = added("slip_jump", course_of(torque, time), step=-6e-5, instant=instant, duration=1e-4)
    np.testing.assert_allclose(found[:70], 0.0, atol=1e-18)
    assert found[70] == pytest.approx(-3e-5, rel=1e-9)
    np.testing.assert_allclose(found[71:], -6e-5, rtol=1e-9)


@pytest.mark.parametrize("constant", [0.05, 0.8, 4.0, 30.0, 500.0])
def test_follower_against_an_integrator(constant: float) -> None:
    rng = np.random.default_rng(7)
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 3.0, 60))])
    driven = np.cumsum(rng.standard_normal(61))
    course = course_of(np.linspace(0, 50, 61), time)
    found = follow(course, driven[None, :], np.array([[constant]]))[0]
    exact = [float(driven[0])]
    for low, high in itertools.pairwise(range(61)):

        def slope(at: float, x: FloatArray) -> FloatArray:
            return (np.interp(at, time, driven) - x) / constant

        solved = solve_ivp(slope, (time[low], time[high]), [exact[-1]], rtol=1e-9, atol=1e-11)
        exact.append(float(solved.y[0, -1]))
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-7)


@pytest.mark.parametrize("pause", [0.0, 40.0])
def test_a_follower_out_of_balance_forgets_its_beginning(pause: float) -> None:
    """Stretches or none, and a pause at once: what it began with fades from time zero on."""
    rng = np.random.default_rng(10)
    steps = rng.uniform(0.2, 3.0, 60)
    steps[1] += pause
    time = np.cumsum(steps)
    course = replace(course_of(np.linspace(0, 50, 60), time), time=time)
    driven = np.cumsum(rng.standard_normal((1, 60)), axis=1)
    constant, beginning = np.array([[0.1], [4.0], [500.0]]), np.array([[2.0], [-1.0], [0.5]])
    fading = np.exp(-time / resolved(course, constant))
    wanted = follow(course, driven, constant) + (beginning - driven[:, :1]) * fading
    found = follow(course, driven, constant, beginning)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)


@pytest.mark.parametrize("constant", [0.01, 0.8, 4.0, 30.0, 500.0])
def test_two_followers_at_once_are_each_of_them(constant: float) -> None:
    rng = np.random.default_rng(8)
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 3.0, 60))])
    course = course_of(np.linspace(0, 50, 61), time)
    driven = np.cumsum(rng.standard_normal((2, 61)), axis=1)
    quick = resolved(course, np.array([[constant], [3.0]]), 1 / 400)
    share = np.array([[0.3], [1.0]])
    mean, fading = follow_two(course, driven, quick, 3, share)
    alone, slow = follow(course, driven, quick), follow(course, driven, 8 * quick)
    wanted = share * alone + (1.0 - share) * slow
    np.testing.assert_allclose(mean, wanted, rtol=0, atol=1e-11)
    np.testing.assert_allclose(fading, np.exp(-time / (8 * quick)), rtol=1e-12)


def test_a_follower_quicker_than_it_can_be_told_stays_finite() -> None:
    course = course_of(np.linspace(0, 50, 401), np.linspace(0, 100, 401))
    driven = np.sin(course.order * 20)[None, :]
    quick = follow(course, driven, np.array([[1e-9]]))
    np.testing.assert_allclose(quick, driven, atol=0.005)
    np.testing.assert_array_equal(quick, follow(course, driven, np.array([[100 / 6400]])))


def test_a_long_record_has_followers_of_every_speed_side_by_side() -> None:
    """Stretch after stretch where one of them is quick: the others come out as by themselves."""
    rng = np.random.default_rng(9)
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 3.0, 600))])
    course = course_of(np.linspace(0, 50, 601), time)
    driven = np.cumsum(rng.standard_normal((1, 601)), axis=1)
    constants = np.array([[0.3], [5.0], [700.0]])
    together = follow(course, driven, constants)
    assert together.shape == (3, 601)
    for found, constant in zip(together, constants, strict=True):
        alone = follow(course, driven, constant[None])[0]
        np.testing.assert_allclose(found, alone, rtol=0, atol=1e-9)


@pytest.mark.parametrize("rougher", [-0.3, 0.3])
def test_slip_with_a_rougher_side_never_moves_against_the_torque(rougher: float) -> None:
    """Sample after sample, the play operator between the two sides' envelopes."""
    torque = random_walk(11)
    values = {"log_stiffness_ratio": np.array([[0.1]]), "log_friction_ratio": np.array([[rougher]])}
    negative = BY_ID["asymmetry"].negative_side(DRIVE, values)
    start = np.array([0.5])
    path = TorquePath.exact(torque)
    found = slip(path, DRIVE, ALPHA, initial_fraction=start, negative=negative)[0]
    side = np.where(torque < 0, 1, 0)
    upward = [slip_envelope(torque, one, ALPHA)[0] for one in (DRIVE, negative)]
    downward = [-slip_envelope(-torque, one, ALPHA)[0] for one in (DRIVE, negative)]
    lower, upper = np.choose(side, upward), np.choose(side, downward)
    state = lower[0] + 0.5 * (upper[0] - lower[0])
    for at, rising in enumerate(path.direction > 0):
        state = max(state, lower[at]) if rising else min(state, upper[at])
        assert found[at] == pytest.approx(state, abs=1e-15)


def test_viscous_followers_stay_numbers_across_a_pause() -> None:
    """Two ramps with a pause of 9 000 time constants between them, stepped through exactly."""
    time = np.concatenate([np.linspace(0.0, 10.0, 60), np.linspace(100.0, 110.0, 60)])
    driven = np.concatenate([np.linspace(0.0, 50.0, 60), np.linspace(50.0, 20.0, 60)])
    course, constant = course_of(driven, time), np.array([[0.02], [0.1]])
    found = follow(course, driven[None, :], constant)
    for row, tau in zip(found, resolved(course, constant)[:, 0], strict=True):
        state = driven[0]
        for at in range(1, time.size):
            step = time[at] - time[at - 1]
            rate = (driven[at] - driven[at - 1]) / step
            lag = (driven[at - 1] - state) * math.exp(-step / tau)
            state = driven[at] - lag - tau * rate * -math.expm1(-step / tau)
            assert row[at] == pytest.approx(state, abs=1e-9)


def test_thermal_drift_is_the_same_for_readings_and_for_their_averages() -> None:
    """Noise of the temperature's sensor widens the readings' range and not the averages'."""
    rng = np.random.default_rng(3)
    torque, time = zigzag(0, 50, -50, 0, samples=1000), np.linspace(0, 90, 3001)
    course = course_of(torque, time, 21 + time / 60 + 0.2 * rng.standard_normal(time.size))
    assert course.temperature is not None
    blocks = course.temperature[:3000].reshape(100, 30).mean(axis=1)
    averaged = replace(course_of(torque[15::30], time[15::30], blocks), scales=course.scales)
    values = {"drift": 4e-5, "softening": 0.0, "time_constant": 0.4, "temperature_gain": 1.0}
    found = added("thermal_drift", course, **values)[:3000].reshape(100, 30).mean(axis=1)
    # The mean over a fortieth of the record, taken twice: at the ends over fewer readings.
    np.testing.assert_allclose(added("thermal_drift", averaged, **values), found, atol=2e-6)


def test_rounding_of_a_coarse_encoder_is_no_ripple() -> None:
    torque = zigzag(0, 60, -60, 60, samples=150)
    fine = plain_angle(torque)
    step = float(np.ptp(fine)) / 27
    for angle, rounded in ((fine, False), (np.round(fine / step) * step, True)):
        scales = record_course(Loop(torque, angle), TorquePath.exact(torque), 0.0).scales
        cycles = BY_ID["angle_ripple"].parameters(scales)[0]
        assert (scales.angle_step is not None) == rounded
        # Neither the ripple nor its second harmonic repeats once a step.
        assert (2 * cycles.second < 1 / step) == rounded
        assert cycles.value(np.array(cycles.grid)).max() < cycles.second


def test_thermal_drift_may_follow_time_beside_a_temperature_that_moves() -> None:
    torque, time = zigzag(0, 60, -60, 60), np.arange(121.0)
    course = course_of(torque, time, 20 + np.sin(time / 9))
    assert course.temperature_beside is not None
    values = {"drift": 4e-5, "softening": 0.0, "time_constant": 0.4}
    alone = added("thermal_drift", course_of(torque, time), **values)
    for gain in (0.0, 0.25, 1.0):
        found = added("thermal_drift", course, temperature_gain=gain, **values)
        wanted = alone + gain * 4e-5 * course.temperature_beside
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-18)
    # Tests of a drive have the same parameters, whether or not their temperatures tell anything.
    names = [
        [one.name for one in BY_ID["thermal_drift"].parameters(each.scales)]
        for each in (course, course_of(torque))
    ]
    assert names[0] == names[1]
    # But nothing is shown of one that only a temperature tells.
    shown = [
        [one.name for one in BY_ID["thermal_drift"].told_parameters(each.scales)]
        for each in (course, course_of(torque))
    ]
    assert shown[0] == names[0]
    assert shown[1] == names[0][:-1]
