"""Loops of a drive with load-independent friction beside its model, whose amplitude is followed."""

from __future__ import annotations

import math

import numpy as np

from hdprog.data.loop import Loop
from hdprog.data.reduce import reduce_loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.noise import NoiseModel
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from hdprog.physics.figures import Operation
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.loop_evidence import FittedLoop
from tests.inference.inverse import coordinates_of
from tests.physics.table2 import POST_TEST

ALPHA = math.radians(30)
OPERATION = Operation(ALPHA, 60.0, 40.0)
PRIOR = read_prior_file("csf-25-80").prior(None)
TRUTH = coordinates_of(PRIOR, POST_TEST)
FRICTION = BY_ID["coulomb_friction"]
NOISE = 1e-5
WIDEST = 2e-4


def likelihood(width: float, seed: int, with_friction: bool = True) -> LoopLikelihood:
    """One loop of an unworn drive with load-independent friction of a width in rad."""
    rng = np.random.default_rng(seed)
    rise = np.linspace(0, 63, 60)
    torque = np.concatenate([rise, rise[-2::-1], -rise[1:], -rise[-2::-1]])
    # A slider by hand: ± half the width, after 1 Nm travelled.
    state, states = 0.0, []
    for step in np.diff(torque, prepend=torque[0]):
        state = float(np.clip(state + step / 0.5, -1, 1))
        states.append(state)
    angle = predict(torque, POST_TEST) - 0.5 * width * np.array(states)
    loop = Loop(torque=torque, angle=angle + NOISE * rng.standard_normal(torque.size))
    reduced = reduce_loop(loop, turning_points(torque), 0.0)
    noise = NoiseModel.white(np.full(reduced.angle.size, NOISE))
    return LoopLikelihood(reduced, PRIOR, ALPHA, noise, (FRICTION,) if with_friction else ())


def followed_by(one: LoopLikelihood) -> FollowedEffects:
    values = {"width": WIDEST, "slip_torque": 0.5, "initial_state": 0.0}
    columns = {name: np.array([[value]]) for name, value in values.items()}
    return FollowedEffects.of(
        (FRICTION,), [(one.reduced.course.scales, {"coulomb_friction": columns})]
    )


def evidence(width: float, hours: float, seed: int, followed: FollowedEffects) -> FittedLoop:
    model = likelihood(width, seed)
    parameters = FRICTION.parameters(model.reduced.course.scales)
    shapes = [p.coordinate(followed.values["coulomb_friction", p.name]) for p in parameters]
    rng = np.random.default_rng(seed + 100)
    centre = np.append(TRUTH, width / WIDEST)
    draws = centre + 0.05 * rng.standard_normal((200, centre.size))
    point = np.concatenate([TRUTH, [0.0], shapes])
    return FittedLoop(hours, None, None, None, draws, model, point, 1.0, followed)
