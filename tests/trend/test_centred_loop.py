"""Own numbers that are counted from where the loop puts them leave its likelihood as it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from hdprog.trend.centred_loop import CentredLoop
from hdprog.trend.exact_likelihood import Nuisances
from hdprog.trend.loop_evidence import FittedLoop
from tests.physics.table2 import POST_TEST
from tests.trend.friction_beside import (
    ALPHA,
    NOISE,
    PRIOR,
    TRUTH,
    WIDEST,
    followed_by,
    likelihood,
)
from tests.trend.friction_beside import evidence as with_followed

VARIANCE = 1.3


def fitted(*effects: str) -> FittedLoop:
    """A test with effects of which none is followed, about coordinates of a plausible size."""
    rng = np.random.default_rng(11)
    torque = np.interp(np.linspace(0, 4, 161), range(5), (0.0, 63.0, -63.0, 63.0, -63.0))
    angle = predict(torque, POST_TEST) + NOISE * rng.standard_normal(torque.size)
    time = np.linspace(0.0, 160.0, torque.size)
    loop = Loop(torque=torque, angle=angle, time=time, output_angle=0.02 * time)
    reduced = reduce_loop(loop, turning_points(torque), 0.0)
    noise = NoiseModel.white(np.full(reduced.angle.size, NOISE))
    chosen = tuple(BY_ID[name] for name in effects)
    model = LoopLikelihood(reduced, PRIOR, ALPHA, noise, chosen)
    point = np.concatenate([TRUTH, [0.3], rng.standard_normal(model.size - COUNT - 1)])
    draws = TRUTH + 0.01 * rng.standard_normal((50, COUNT))
    return FittedLoop(0.0, None, None, None, draws, model, point, VARIANCE, None)


def carrying(loop: FittedLoop) -> FittedLoop:
    """The same test of a record that carries the effects as the fit has them."""
    model = loop.likelihood
    angle = model.angle(loop.point[None])[0]
    angle = angle + NOISE * np.random.default_rng(14).standard_normal(angle.size)
    return replace(loop, likelihood=replace(model, reduced=replace(model.reduced, angle=angle)))


def near(loop: FittedLoop, own: Nuisances, draws: int) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and own numbers about the mode."""
    rng = np.random.default_rng(12)
    lower = np.linalg.cholesky(np.linalg.inv(own.precision))
    coordinates = TRUTH + 0.01 * rng.standard_normal((draws, COUNT))
    numbers = own.mean + rng.standard_normal((draws, own.mean.size)) @ lower.T
    return coordinates, numbers


@pytest.mark.parametrize(
    ("effects", "apart"),
    [
        (("kinematic_error", "creep"), True),
        (("angle_ripple",), False),
        (("asymmetry",), False),
        (("torque_offset", "backlash"), False),
    ],
    ids=lambda value: "+".join(value) if isinstance(value, tuple) else "",
)
def test_the_density_is_that_of_the_loop_s_own_numbers(
    effects: tuple[str, ...], apart: bool
) -> None:
    loop = fitted(*effects)
    plain, (centred, own) = loop.nuisances(TRUTH), loop.about(TRUTH)
    assert isinstance(centred, CentredLoop)
    assert (centred.bare is not None) == apart
    coordinates, numbers = near(loop, own, 40)

    # m(x) by its formula, from residuals and their differences.
    held = numbers.copy()
    held[:, 1:] = plain.mean[1:]
    step = 1e-5
    at = loop.points(TRUTH[None], plain.mean[None])
    moved = np.repeat(at, 2 * (plain.mean.size - 1), axis=0)
    moved[:, COUNT + 1 :] += (
        step
        * np.concatenate([np.eye(plain.mean.size - 1)] * 2)
        * np.repeat([1.0, -1.0], plain.mean.size - 1)[:, None]
    )
    ahead, behind = np.split(loop.likelihood.residual(moved), 2)
    derivative = (behind - ahead).T / (2 * step)
    left = loop.likelihood.residual(loop.points(coordinates, held))
    precision = derivative.T @ derivative / VARIANCE + np.eye(plain.mean.size - 1)
    pull = left @ derivative / VARIANCE - plain.mean[1:]
    z = plain.mean[1:] + np.linalg.solve(precision, pull.T).T + numbers[:, 1:]

    whole = np.column_stack([numbers[:, 0], z])
    expected = loop.log_likelihood(coordinates, whole) - 0.5 * np.sum(whole**2, axis=1)
    found = centred.log_likelihood(coordinates, numbers) - 0.5 * np.sum(numbers**2, axis=1)
    assert np.isfinite(expected).all()
    assert found == pytest.approx(expected, abs=0.02)


def test_centred_numbers_stay_at_their_best_while_the_state_moves() -> None:
    """Where the loop's own numbers, left where they are, would fall far below theirs."""
    loop = carrying(fitted("kinematic_error", "creep"))
    plain, (centred, _) = loop.nuisances(TRUTH), loop.about(TRUTH)
    coordinates = TRUTH + 0.01 * np.random.default_rng(13).standard_normal((20, COUNT))
    best = np.array([loop.nuisances(one).mean for one in coordinates])
    held = np.repeat(plain.mean[None], len(best), axis=0)
    held[:, 0] = best[:, 0]
    zero = np.zeros_like(held)
    zero[:, 0] = best[:, 0]

    def density(of: FittedLoop | CentredLoop, numbers: np.ndarray) -> np.ndarray:
        return of.log_likelihood(coordinates, numbers) - 0.5 * np.sum(numbers**2, axis=1)

    highest = density(loop, best)
    fallen = np.median(highest - density(loop, held))
    assert fallen > 2.0
    assert np.median(highest - density(centred, zero)) < 0.3 * fallen


def test_what_is_followed_is_not_centred() -> None:
    loop = with_followed(0.5 * WIDEST, 0.0, 3, followed_by(likelihood(0.0, 1)))
    found, own = loop.about(np.append(TRUTH, 0.5))
    assert found is loop
    assert own.mean == pytest.approx(loop.nuisances(np.append(TRUTH, 0.5)).mean)


def test_a_followed_effect_beside_a_free_one_stays_with_the_state() -> None:
    followed = followed_by(likelihood(0.0, 1))
    one = with_followed(0.5 * WIDEST, 0.0, 3, followed)
    model = replace(one.likelihood, effects=(*one.likelihood.effects, BY_ID["backlash"]))
    loop = replace(one, likelihood=model, point=np.append(one.point, [-0.5, 0.2, 0.1]))
    at = np.append(TRUTH, 0.5)
    centred, own = loop.about(at)
    assert isinstance(centred, CentredLoop)
    assert len(centred.centred) == 3
    held = np.repeat(own.mean[None], 5, axis=0)
    coordinates = np.repeat(at[None], 5, axis=0)
    coordinates[:, -1] += [-0.2, -0.1, 0.0, 0.1, 0.2]
    density = centred.log_likelihood(coordinates, held)
    assert np.isfinite(density).all()
    assert density.argmax() == 2
