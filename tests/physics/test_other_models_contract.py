"""What every competitor of the drive model promises, on one- and on two-sided records."""

from __future__ import annotations

import re

import numpy as np
import pytest

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.physics.course import Course
from hdprog.physics.other_models import BY_ID, MODELS
from hdprog.physics.other_models.base import OtherModel, Setting, values_of
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

IDS = [
    "ideal",
    "tuttle",
    "catalogue_piecewise",
    "cubic",
    "dhaouadi",
    "zhang",
    "seyfferth",
    "taghirad",
    "preisach",
    "maxwell_slip",
]
SIDES = {"two-sided": (0.0, 40.0, -40.0, 40.0, -20.0, 10.0, 0.0), "one-sided": (0.0, 40.0, 0.0)}

each = pytest.mark.parametrize("model", MODELS, ids=lambda model: model.id)
sides = pytest.mark.parametrize("corners", SIDES.values(), ids=SIDES)


def course_of(corners: tuple[float, ...], mirrored: bool = False) -> Course:
    at = np.cumsum([0.0, *np.abs(np.diff(corners)) / 2])
    time = np.unique(np.concatenate([np.linspace(0.0, at[-1], 241), at]))
    torque = np.interp(time, at, corners) * (-1 if mirrored else 1)
    loop = Loop(torque, torque / 1.5e4, time=time, output_angle=1.0 + 0.003 * time)
    return record_course(loop, TorquePath.exact(torque), 0.0)


def drawn(model: OtherModel, setting: Setting, draws: int, seed: int = 1) -> FloatArray:
    """Coordinates (draws, parameters) from the prior, inside the support."""
    rng = np.random.default_rng(seed)
    parameters = model.parameters(setting)
    found = rng.standard_normal((60 * draws, len(parameters)))
    found = np.abs(found) if model.nonnegative else found
    return (
        found[model.inside(values_of(parameters, found), setting)][:draws]
        if parameters
        else found[:1]
    )


def angle(model: OtherModel, course: Course, coordinates: FloatArray) -> FloatArray:
    setting = Setting.of(course)
    return model.angle(course, values_of(model.parameters(setting), coordinates), setting)


def test_the_list_is_that_of_the_physics() -> None:
    assert [model.id for model in MODELS] == IDS
    assert dict(BY_ID) == {model.id: model for model in MODELS}


@each
def test_a_model_says_what_it_is_and_where_it_comes_from(model: OtherModel) -> None:
    assert re.search(r"[=Σ]", type(model).__doc__ or "")
    assert re.search(r"eqs?\.? \d|A\d|introduction", model.source)
    assert model.words
    assert model.where
    parameters = model.parameters(Setting.of(course_of(SIDES["two-sided"])))
    assert all(one.name and one.unit and one.meaning for one in parameters)
    assert len({one.name for one in parameters}) == len(parameters)


@each
@sides
def test_shapes_finite_values_and_draws_that_do_not_mix(
    model: OtherModel, corners: tuple[float, ...]
) -> None:
    course = course_of(corners)
    coordinates = drawn(model, Setting.of(course), 40)
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        together = angle(model, course, coordinates)
    assert together.shape == (len(coordinates), course.path.torque.size)
    assert np.isfinite(together).all()
    for draw in range(0, len(coordinates), 7):
        alone = angle(model, course, coordinates[draw : draw + 1])
        np.testing.assert_allclose(alone[0], together[draw], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("model", [one for one in MODELS if one.id not in ("tuttle", "ideal")])
@sides
def test_angle_follows_torque_without_jumps(model: OtherModel, corners: tuple[float, ...]) -> None:
    """Between neighbouring samples, also over reversals; Taghirad's p < 1 jumps by definition."""
    course = course_of(corners)
    setting = Setting.of(course)
    parameters = model.parameters(setting)
    coordinates = np.full((1, len(parameters)), 0.4)
    if model.id == "taghirad":
        coordinates[0, 3] = 1.0
    found = angle(model, course, coordinates)[0]
    steps = np.diff(found) * np.sign(np.diff(course.path.torque))
    assert (steps >= -1e-12).all()
    softest = 25 / setting.stiffness
    assert np.abs(np.diff(found)).max() < softest * np.abs(np.diff(course.path.torque)).max()


@each
@sides
def test_odd_where_claimed(model: OtherModel, corners: tuple[float, ...]) -> None:
    course, mirror = course_of(corners), course_of(corners, mirrored=True)
    setting = Setting.of(course)
    coordinates = drawn(model, setting, 12)
    mirrored = coordinates.copy()
    for index, one in enumerate(model.parameters(setting)):
        if one.name == "initial_state":
            mirrored[:, index] *= -1
    apart = angle(model, course, coordinates) + angle(model, mirror, mirrored)
    if model.odd:
        assert np.abs(apart).max() < 1e-9
    elif len(corners) > 3:
        assert np.abs(apart).max() > 1e-6


@pytest.mark.parametrize("model", [one for one in MODELS if one.id != "tuttle"])
def test_branches_lie_apart_only_where_there_is_hysteresis(model: OtherModel) -> None:
    course = course_of((0.0, 40.0, -40.0, 40.0, -40.0))
    setting = Setting.of(course)
    coordinates = drawn(model, setting, 5)
    found, torque = angle(model, course, coordinates), course.path.torque
    starts, ends = course.path.starts, course.path.ends
    rising = np.interp(0.0, torque[starts[2] : ends[2]], found[0, starts[2] : ends[2]])
    falling = np.interp(0.0, -torque[starts[3] : ends[3]], found[0, starts[3] : ends[3]])
    assert (falling - rising > 1e-8) == model.hysteresis
    assert falling - rising > -1e-12


@each
def test_a_stiffness_curve_is_odd_and_rises(model: OtherModel) -> None:
    course = course_of(SIDES["two-sided"])
    setting = Setting.of(course)
    coordinates = drawn(model, setting, 6)
    torque = np.linspace(-40.0, 40.0, 41)
    values = values_of(model.parameters(setting), coordinates)
    curve = model.stiffness_curve(torque, values, setting)
    if curve is None:
        assert model.nonnegative or model.id == "ideal"
        return
    np.testing.assert_allclose(curve, -curve[:, ::-1], atol=1e-12)
    assert (np.diff(curve, axis=1) > 0).all()


@each
def test_what_a_record_lacks_is_said(model: OtherModel) -> None:
    torque = np.concatenate([np.linspace(0, 40, 40), np.linspace(39, 0, 40)])
    bare = record_course(Loop(torque, torque / 1e4), TorquePath.exact(torque), 0.0)
    assert model.missing(course_of(SIDES["two-sided"])) is None
    if model.id == "tuttle":
        assert model.missing(bare) == "needs time_s and output_angle_rad"
    else:
        assert model.missing(bare) is None


def test_an_output_that_stands_still_shows_no_speed() -> None:
    torque = np.concatenate([np.linspace(0, 40, 40), np.linspace(39, 0, 40)])
    loop = Loop(torque, torque / 1e4, time=np.arange(80.0), output_angle=np.full(80, 0.3))
    missing = BY_ID["tuttle"].missing(record_course(loop, TorquePath.exact(torque), 0.0))
    assert missing is not None
    assert "stands still" in missing
