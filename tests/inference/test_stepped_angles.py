"""Steps along one coordinate lead to the same angles, whether or not the others are worked out."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.stepped_angles import stepped_angles
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID, EFFECTS
from hdprog.physics.effects.base import Effect
from tests.inference.test_likelihood import ALPHA, PRIOR
from tests.physics.table2 import POST_TEST

STEP = 0.01


@cache
def plain() -> LoopLikelihood:
    """Of a record with time, temperature and output position."""
    ramp = np.linspace(0.0, 63.0, 40)
    torque = np.concatenate([ramp, ramp[-2::-1], -ramp[1:], -ramp[-2::-1]])
    place = np.linspace(0.0, 1.0, torque.size)
    loop = Loop(
        torque=torque,
        angle=predict(torque, POST_TEST),
        time=600.0 * place,
        temperature=20.0 + 5.0 * place,
        output_angle=0.3 * place,
    )
    reduced = reduce_loop(loop, turning_points(torque), 0.0)
    noise = NoiseModel.white(np.full(reduced.angle.size, 1e-5))
    return LoopLikelihood(reduced, PRIOR, ALPHA, noise)


def with_effects(*names: str) -> tuple[LoopLikelihood, np.ndarray]:
    """And three points of it."""
    model = replace(plain(), effects=tuple(BY_ID[name] for name in names))
    points = model.prior_mean + 0.3 * np.random.default_rng(3).standard_normal((3, model.size))
    return model, points


def one_by_one(model: LoopLikelihood, points: np.ndarray) -> np.ndarray:
    """Each step's angle from the whole model."""
    found = [model.angle(points)]
    for by in (STEP, -STEP):
        found += [model.angle(points + by * unit) for unit in np.eye(model.size)]
    return np.stack(found, axis=1)


@pytest.mark.parametrize(
    "names",
    [(), *((effect.id,) for effect in EFFECTS), ("kinematic_error", "creep", "thermal_drift")],
    ids=lambda names: "+".join(names) or "none",
)
def test_as_if_all_of_it_were_worked_out(names: tuple[str, ...]) -> None:
    model, points = with_effects(*names)
    found, wanted = stepped_angles(model, points, (STEP, -STEP)), one_by_one(model, points)
    assert found.shape == wanted.shape == (3, 1 + 2 * model.size, model.blocks)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-16 + 2e-15 * np.abs(wanted).max())
    moved = np.abs(found[:, 1 : 1 + model.size] - found[:, :1]).max(axis=(0, 2))
    assert (moved > 0).all(), "a coordinate that does nothing"


def test_the_drive_is_not_worked_out_again_for_what_effects_have(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model, points = with_effects("kinematic_error", "creep")
    rows = []
    whole = LoopLikelihood.angle
    monkeypatch.setattr(
        LoopLikelihood,
        "angle",
        lambda self, points: rows.append(len(points)) or whole(self, points),
    )
    stepped_angles(model, points, (STEP,))
    assert rows == [3 * (1 + COUNT + 1)]


def test_a_model_without_coordinates_has_no_steps() -> None:
    class Fixed(LoopLikelihood):
        size, held = 0, None

        def angle(self, points: np.ndarray) -> np.ndarray:
            return np.ones((len(points), self.blocks))

    model = plain()
    fixed = Fixed(model.reduced, model.prior, model.alpha, model.noise)
    assert stepped_angles(fixed, np.zeros((2, 0)), (STEP,)).shape == (2, 1, model.blocks)


@pytest.mark.parametrize("effect", [one for one in EFFECTS if one.acts_on == "angle"])
def test_an_effect_follows_the_angle_where_it_says_so(effect: Effect) -> None:
    model, points = with_effects(effect.id)
    values = model.effect_values(points)[effect.id]
    course = model.reduced.course
    near, far = (effect.evaluate(course, values, by * course.load[None]) for by in (1.0, 2.0))
    assert bool(np.any(near != far)) is effect.follows_angle
