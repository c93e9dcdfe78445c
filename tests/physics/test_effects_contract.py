"""What every effect promises: identity, priors, shapes, separate draws, a size that counts."""

from __future__ import annotations

import math
import pickle
import re
from collections.abc import Callable

import numpy as np
import pytest

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.physics.course import Course
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.effects import BY_ID, EFFECTS
from hdprog.physics.effects.base import Effect, EffectParameter, Values
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.torque_path import TorquePath
from tests.physics.table2 import POST_TEST

ALPHA = math.radians(30)
IDS = [
    "torque_offset",
    "backlash",
    "asymmetry",
    "cup_hardening",
    "coulomb_friction",
    "microslip",
    "viscous_friction",
    "stribeck_friction",
    "creep",
    "thermal_drift",
    "kinematic_error",
    "angle_ripple",
    "torque_sensor_hysteresis",
    "tooth_damage",
    "slip_jump",
]
# Coordinate of an amplitude that is as good as absent; exp(−45) of its typical size if positive.
ABSENT = {"log": -30.0, "signed": 0.0}

each = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.id)


@each
def test_an_effect_from_another_process_is_the_same_effect(effect: Effect) -> None:
    again = pickle.loads(pickle.dumps(effect))
    assert again == effect
    assert [other.id for other in EFFECTS if other == again] == [effect.id]
    assert {again} == {effect}


def rich_course() -> Course:
    """Both signs, two rates, a minor loop, a warming rig and a turning output."""
    corners = [0.0, 40.0, -40.0, 40.0, -20.0, 10.0, 0.0]
    at = np.cumsum([0.0, 20.0, 40.0, 10.0, 8.0, 15.0, 5.0])
    time = np.unique(np.concatenate([np.linspace(0.0, at[-1], 241), at]))
    torque = np.interp(time, at, corners)
    loop = Loop(
        torque=torque,
        angle=torque / 1.5e4,
        time=time,
        temperature=20.0 + 5.0 * (1 - np.exp(-time / 40.0)),
        output_angle=1.0 + 0.003 * time,
    )
    return record_course(loop, TorquePath.exact(torque), 0.0)


COURSE = rich_course()
SAMPLES = COURSE.path.torque.size


def drives(draws: int) -> Parameters:
    """Drives around Table 2's worn state, (draws,) each."""
    rng = np.random.default_rng(3)
    return {
        name: np.asarray(value * np.exp(0.05 * rng.standard_normal(draws)))
        for name, value in POST_TEST.items()
    }


def one(parameters: Parameters, draw: int) -> Parameters:
    return {name: values[draw : draw + 1] for name, values in parameters.items()}


def base_angle(parameters: Parameters, fraction: FloatArray) -> FloatArray:
    return torsion_angle(COURSE.path, parameters, ALPHA, initial_fraction=fraction)


def with_effects(
    effects: EffectSet, parameters: Parameters, coordinates: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Angle with effects and without, (draws, samples) each."""
    fraction = np.full(len(coordinates), 0.4)
    values = effects.values(coordinates)
    found = effects.angle(COURSE, parameters, values, ALPHA, fraction)
    return found, base_angle(parameters, fraction)


def outputs(effect: Effect, values: Values, parameters: Parameters) -> list[FloatArray]:
    """Everything that an effect gives back, whichever quantity it acts on."""
    if effect.acts_on == "angle":
        angle = base_angle(parameters, np.full(parameters["K_F"].size, 0.4))
        return [effect.evaluate(COURSE, values, angle)]
    if effect.acts_on == "torque":
        return list(effect.torque_error(COURSE, values))
    return list(effect.negative_side(parameters, values).values())


def sized(effects: EffectSet, amplitude: Callable[[EffectParameter], float]) -> FloatArray:
    """Coordinates (1, size): amplitudes as asked, everything else at its median."""
    return np.array([[amplitude(one) if one.amplitude else 0.0 for _, one in effects.parameters]])


def test_the_list_is_that_of_the_physics() -> None:
    assert [effect.id for effect in EFFECTS] == IDS
    assert dict(BY_ID) == {effect.id: effect for effect in EFFECTS}


@each
def test_an_effect_says_what_it_is(effect: Effect) -> None:
    docstring = type(effect).__doc__ or ""
    equation, source = r"[=·Σ]|exp\(", r"\(\d+\)|\((19|20)\d\d\)"
    assert re.search(f"{equation}|{source}", docstring)
    assert len(effect.words.split()) > 2
    assert effect.advice.endswith(".")
    parameters = effect.parameters(COURSE.scales)
    assert all(one.name and one.unit and one.meaning for one in parameters)
    names = [one.name for one in parameters]
    assert len(set(names)) == len(names)
    assert any(one.amplitude for one in parameters)
    assert all(one.transform in ABSENT for one in parameters if one.amplitude)


@each
def test_transforms_invert(effect: Effect) -> None:
    coordinates = np.linspace(-2.5, 2.5, 11)
    for one_parameter in effect.parameters(COURSE.scales):
        values = one_parameter.value(coordinates)
        assert (np.diff(values) > 0).all()
        back = [one_parameter.coordinate(float(value)) for value in values]
        np.testing.assert_allclose(back, coordinates, atol=1e-9)
        grid = one_parameter.gridded(values)
        np.testing.assert_allclose(grid.grid, coordinates, atol=1e-9)
        assert grid.value(coordinates).tolist() == values.tolist()


def test_values_out_of_reach_stay_finite() -> None:
    log = EffectParameter("x", "-", "x", "log", 2.0, 1.0)
    between = EffectParameter("x", "-", "x", "between", -1.0, 1.0)
    found = [log.coordinate(0.0), log.coordinate(-1.0), between.coordinate(1.0)]
    assert np.isfinite(found).all()


@each
def test_shapes_and_draws_that_do_not_mix(effect: Effect) -> None:
    effects = EffectSet((effect,), COURSE.scales)
    coordinates = np.random.default_rng(1).standard_normal((5, effects.size))
    parameters = drives(5)
    values = effects.values(coordinates)[effect.id]
    assert all(value.shape == (5, 1) for value in values.values())
    together = outputs(effect, values, parameters)
    if effect.acts_on == "angle":
        assert [part.shape for part in together] == [(5, SAMPLES)]
    elif effect.acts_on == "torque":
        assert [part.shape for part in together] == [(5, SAMPLES), (5, COURSE.path.starts.size)]
    else:
        assert {part.shape for part in together} == {(5,)}
    for draw in range(5):
        alone_values = effects.values(coordinates[draw : draw + 1])[effect.id]
        alone = outputs(effect, alone_values, one(parameters, draw))
        for whole, part in zip(together, alone, strict=True):
            np.testing.assert_allclose(whole[draw], part[0], rtol=1e-12, atol=1e-18)


@each
def test_finite_wherever_the_prior_goes(effect: Effect) -> None:
    effects = EffectSet((effect,), COURSE.scales)
    coordinates = np.random.default_rng(2).standard_normal((400, effects.size))
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        angle, _ = with_effects(effects, drives(400), coordinates)
    assert angle.shape == (400, SAMPLES)
    assert np.isfinite(angle).all()


@each
def test_an_effect_is_as_large_as_its_amplitude(effect: Effect) -> None:
    effects = EffectSet((effect,), COURSE.scales)
    parameters = drives(1)
    absent = sized(effects, lambda one: ABSENT[one.transform])
    found, base = with_effects(effects, parameters, absent)
    np.testing.assert_allclose(found, base, rtol=0, atol=1e-15)
    sizes = [sized(effects, lambda _: 0.5), sized(effects, lambda _: 1.0)]
    pairs = [with_effects(effects, parameters, size) for size in sizes]
    changes = [float(np.std(found - base)) for found, base in pairs]
    # An effect of typical size stands clear of an encoder's 1e-5 rad or nearly so, and grows.
    assert changes[0] > 2e-6
    assert changes[1] > 1.2 * changes[0]


@each
def test_only_its_own_door_is_open(effect: Effect) -> None:
    values = EffectSet((effect,), COURSE.scales).values(np.zeros((1, 9)))[effect.id]
    parameters = drives(1)
    doors: dict[str, Callable[[], object]] = {
        "angle": lambda: effect.evaluate(COURSE, values, np.zeros((1, SAMPLES))),
        "torque": lambda: effect.torque_error(COURSE, values),
        "parameters": lambda: effect.negative_side(parameters, values),
    }
    del doors[effect.acts_on]
    for door in doors.values():
        with pytest.raises(NotImplementedError, match=effect.id):
            door()


def test_coordinates_are_laid_out_effect_by_effect() -> None:
    names = ("creep", "torque_offset", "tooth_damage")
    effects = EffectSet((BY_ID["creep"], BY_ID["torque_offset"]), COURSE.scales)
    wider = EffectSet((*effects.effects, BY_ID["tooth_damage"]), COURSE.scales)
    assert [effect.id for effect in wider.effects] == list(names)
    wanted = [
        (name, parameter.name)
        for name in names
        for parameter in BY_ID[name].parameters(COURSE.scales)
    ]
    assert [(effect.id, parameter.name) for effect, parameter in wider.parameters] == wanted
    assert (wider.size, effects.size) == (len(wanted), len(wanted) - 3)
    coordinates = np.random.default_rng(4).standard_normal((2, wider.size))
    values = wider.values(coordinates)
    assert tuple(values) == names
    for index, (effect, parameter) in enumerate(wider.parameters):
        found = values[effect.id][parameter.name]
        np.testing.assert_array_equal(found, parameter.value(coordinates[:, index, None]))


def test_no_effect_is_the_drive_model() -> None:
    nothing = EffectSet((), COURSE.scales)
    found, base = with_effects(nothing, drives(3), np.zeros((3, 0)))
    np.testing.assert_array_equal(found, base)


def test_effects_on_the_angle_add_up() -> None:
    names = ("creep", "backlash", "slip_jump")
    parameters = drives(1)
    together = EffectSet(tuple(BY_ID[name] for name in names), COURSE.scales)
    coordinates = np.random.default_rng(5).standard_normal((1, together.size))
    found, base = with_effects(together, parameters, coordinates)
    total, first = base.copy(), 0
    for name in names:
        alone = EffectSet((BY_ID[name],), COURSE.scales)
        part = coordinates[:, first : first + alone.size]
        total += with_effects(alone, parameters, part)[0] - base
        first += alone.size
    np.testing.assert_allclose(found, total, rtol=0, atol=1e-15)


def test_errors_of_the_torque_sensor_add_up() -> None:
    offset, lag = BY_ID["torque_offset"], BY_ID["torque_sensor_hysteresis"]
    both = EffectSet((offset, lag), COURSE.scales)
    coordinates = np.full((1, both.size), 1.2)
    values, parameters = both.values(coordinates), drives(1)
    shift = values["torque_offset"]["zero_torque"][0, 0]
    along, ends = lag.torque_error(COURSE, values[lag.id])
    path = TorquePath(
        COURSE.path.torque - shift - along,
        COURSE.path.starts,
        COURSE.path.rising,
        reversal_torque=COURSE.path.reached - shift - ends,
    )
    fraction = np.full(1, 0.4)
    wanted = torsion_angle(path, parameters, ALPHA, initial_fraction=fraction)
    found, base = with_effects(both, parameters, coordinates)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-15)
    assert np.abs(found - base).max() > 1e-5


def test_the_order_of_effects_does_not_matter() -> None:
    names = ("torque_offset", "asymmetry", "tooth_damage", "torque_sensor_hysteresis")
    parameters = drives(1)
    forward = EffectSet(tuple(BY_ID[name] for name in names), COURSE.scales)
    backward = EffectSet(tuple(BY_ID[name] for name in reversed(names)), COURSE.scales)
    values = forward.values(np.full((1, forward.size), 0.7))
    fraction = np.full(1, 0.4)
    found = [
        effects.angle(COURSE, parameters, values, ALPHA, fraction)
        for effects in (forward, backward)
    ]
    np.testing.assert_allclose(*found, rtol=0, atol=1e-15)


def angle_held(effects: EffectSet, drawn: FloatArray, parameters: Parameters) -> FloatArray:
    fraction = np.full(parameters["K_F"].size, 0.4)
    held = effects.held(COURSE, effects.values(drawn))
    return held.angle(parameters, ALPHA, fraction)


@each
def test_held_at_a_value_it_is_the_same_to_the_last_bit(effect: Effect) -> None:
    effects = EffectSet((effect, BY_ID["backlash"]), COURSE.scales)
    drawn = 0.3 * np.ones((1, effects.size))
    parameters = drives(5)
    expected, _ = with_effects(effects, parameters, np.repeat(drawn, 5, axis=0))
    np.testing.assert_array_equal(angle_held(effects, drawn, parameters), expected)


def test_only_what_hangs_on_the_angle_is_worked_out_again() -> None:
    effects = EffectSet((BY_ID["creep"], BY_ID["angle_ripple"]), COURSE.scales)
    held = effects.held(COURSE, effects.values(np.zeros((1, effects.size))))
    creep, ripple = held.known
    assert creep is not None
    assert ripple is None
