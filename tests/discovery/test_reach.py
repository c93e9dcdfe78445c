"""Effects of a size that no record can carry are refused.

A torque sensor whose zero drifts was explained by a zero of half the torque and a lag over seventy
times the record's torque, which nearly cancel.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.discovery.reach import within_reach
from hdprog.discovery.search import trace
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.starting_points import describe
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from hdprog.physics.parameters import FloatArray
from tests.physics.table2 import POST_TEST

PRIOR = read_prior_file("csf-25-80").prior(None)


@lru_cache
def drifting() -> Loop:
    """±63 Nm three times; the torque's zero drifts by 6 Nm."""
    corners = 63.0 * np.array([0.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    at = np.array([0.0, *np.arange(1.0, 14.0, 2.0)])
    time: FloatArray = np.linspace(0.0, 13.0, 420)
    torque: FloatArray = np.interp(time, at, corners)
    noise = 6e-6 * np.random.default_rng(2).standard_normal(time.size)
    angle = predict(torque, POST_TEST) + noise
    return Loop(torque + 6.0 * time / time[-1], angle, 10.0 * time)


@lru_cache
def likelihood() -> LoopLikelihood:
    prepared = prepare(drifting(), Drive.default(), np.random.default_rng(0), prior=PRIOR)
    return prepared.likelihood


def reached(effect: str, **values: float) -> bool:
    model = replace(likelihood(), effects=(BY_ID[effect],))
    parameters = BY_ID[effect].parameters(model.reduced.course.scales)
    own = np.zeros(len(parameters))
    for index, one in enumerate(parameters):
        if one.name in values:
            # Not `coordinate`, which holds a value to what the prior can have drawn.
            inverse = np.log if one.transform == "log" else np.arcsinh
            own[index] = inverse(values[one.name] / one.first) / one.second
    start = np.concatenate([likelihood().prior_mean, own])
    return within_reach(model, describe(model, start))


@pytest.mark.parametrize(
    ("effect", "values", "carried"),
    [
        ("torque_offset", {"zero_torque": 6.0}, True),
        ("torque_offset", {"zero_torque": -20.0}, True),
        ("torque_offset", {"zero_torque": 40.0}, False),
        ("torque_sensor_hysteresis", {"lag": 2.0, "travel": 60.0}, True),
        ("torque_sensor_hysteresis", {"lag": 2.0, "travel": 4400.0}, False),
        ("backlash", {"play": 4e-4, "width": 0.7}, True),
        ("backlash", {"play": 4e-4, "width": 2.5}, True),
        ("backlash", {"play": 4e-4, "width": 45.0}, False),  # a bend over the whole loop, no play
        ("backlash", {"play": 2e-2, "width": 0.7}, False),
        ("backlash", {"play": 1e-17, "width": 0.7}, True),  # as good as absent
    ],
)
def test_sizes_that_a_record_can_carry(
    effect: str, values: dict[str, float], carried: bool
) -> None:
    assert reached(effect, **values) == carried


def test_a_zero_that_drifts_is_no_zero_and_lag_that_cancel() -> None:
    some = tuple(BY_ID[name] for name in ("torque_offset", "torque_sensor_hysteresis"))
    prepared = prepare(drifting(), Drive.default(), np.random.default_rng(0), prior=PRIOR)
    (found,) = trace([prepared], [np.random.SeedSequence(1)], some)
    for step in found.steps:
        for candidate in step.models.values():
            assert within_reach(candidate.likelihood, candidate.start)
    final = found.final
    values = final.likelihood.effect_values(final.start.point[None])
    if "torque_offset" in values:
        assert abs(float(values["torque_offset"]["zero_torque"][0, 0])) < 6.0
