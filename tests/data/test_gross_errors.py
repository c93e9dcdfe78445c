"""Readings that are wrong beyond doubt are levelled before a model is fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.data.gross_errors import levelled
from hdprog.data.loop import Loop
from hdprog.data.noise_level import quantisation_step
from hdprog.data.turning_points import turning_points


def triangle(samples: int, noise: float) -> Loop:
    """Two cycles to 50 Nm, sampled evenly, with noise of both channels in units of a step."""
    rng = np.random.default_rng(3)
    at = np.linspace(0, 8, samples)
    torque = 50 * np.interp(at, np.arange(9), [0, 1, 0, -1, 0, 1, 0, -1, 0])
    step = float(np.median(np.abs(np.diff(torque))))
    angle = torque / 10_000 + 1e-3 * np.tanh(torque / 5)
    torque = torque + noise * step * rng.standard_normal(samples)
    return Loop(
        torque=torque,
        angle=angle + noise * step / 10_000 * rng.standard_normal(samples),
        time=np.arange(samples, dtype=float),
    )


@pytest.mark.parametrize("noise", [0.0, 0.3, 3.0])
@pytest.mark.parametrize("samples", [80, 400, 4000])
def test_a_sound_record_is_left_alone(samples: int, noise: float) -> None:
    loop = triangle(samples, noise)
    same, wrong = levelled(loop)
    assert same is loop
    assert not wrong.any()


@pytest.mark.parametrize("channel", ["torque", "angle"])
@pytest.mark.parametrize("where", [[0], [399], [100], [50, 51], [51, 200, 290, 291, 350]])
def test_wrong_readings_are_drawn_straight(channel: str, where: list[int]) -> None:
    loop = triangle(400, 0.3)
    values = getattr(loop, channel).copy()
    span = np.ptp(values)
    values[where] += 3 * span

    same, wrong = levelled(replace(loop, **{channel: values}))
    assert np.flatnonzero(wrong).tolist() == where
    assert np.abs(getattr(same, channel) - getattr(loop, channel)).max() < 0.05 * span
    turns = turning_points(same.torque, time=same.time)
    assert np.abs(turns - turning_points(loop.torque, time=loop.time)).max() <= 2


def test_a_coarse_angle_keeps_its_steps() -> None:
    """Lines through spikes ran between them: the steps passed for half as wide."""
    loop = triangle(400, 0.3)
    coarse = 4e-4 * np.round(loop.angle / 4e-4)
    spoilt = coarse.copy()
    spoilt[[30, 77, 130, 181, 222, 260, 311, 350]] += 0.02
    same, wrong = levelled(replace(loop, angle=spoilt))
    assert wrong.sum() == 8
    assert np.abs(same.angle - coarse).max() < 1.5 * 4e-4
    assert quantisation_step(same.angle) == pytest.approx(4e-4)


def test_temperature_and_output_angle_are_drawn_straight_and_set_nothing_aside() -> None:
    """Rounded to the tenth of a degree, as thermometers are; both span what effects scale by."""
    index = np.arange(400.0)
    warming = np.round(25.0 + 0.6 * index / 400.0, 1)
    turned = 1.0 + 0.05 * index / 400.0
    loop = replace(triangle(400, 0.3), temperature=warming, output_angle=turned)
    hot, lost = warming.copy(), turned.copy()
    hot[150], lost[[77, 78]] = 850.0, 0.0

    same, wrong = levelled(replace(loop, temperature=hot, output_angle=lost))
    assert not wrong.any()
    assert same.temperature is not None
    assert same.output_angle is not None
    assert np.abs(same.temperature - warming).max() < 0.11
    assert np.abs(same.output_angle - turned).max() < 1e-6


def stepwise(hold: int, top: int, noise: float) -> Loop:
    """Dead weights put on and taken off, each side's largest for a few readings only."""
    levels = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]
    held = [(side * level, hold) for side in (1, -1) for level in levels]
    rise, fall = held[:6], held[6:]
    course = [*rise, (60.0, top), *rise[::-1], *fall, (-60.0, top), *fall[::-1]]
    torque = np.concatenate([np.full(readings, level) for level, readings in course])
    rng = np.random.default_rng(5)
    twist = torque / 30_000 + 2e-4 * np.tanh(torque / 5) + 2e-6 * rng.standard_normal(torque.size)
    return Loop(torque=torque + noise * rng.standard_normal(torque.size), angle=twist)


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("top", [1, 2])
@pytest.mark.parametrize("hold", [3, 10, 20])
def test_a_short_step_of_dead_weights_is_no_error(hold: int, top: int, noise: float) -> None:
    loop = stepwise(hold, top, noise)
    same, wrong = levelled(loop)
    assert same is loop
    assert not wrong.any()


@pytest.mark.parametrize(
    ("torque", "angle"),
    [(10.0, 0.0), (0.0, 5e-4), (10.0, -5e-4), (10.0, 5e-3), (40.0, 3e-4), (150.0, 0.0)],
)
@pytest.mark.parametrize("where", [[5], [115], [131], [131, 132], [300]])
def test_wrong_readings_are_found_beside_such_steps(
    torque: float, angle: float, where: list[int]
) -> None:
    loop = stepwise(20, 2, 0.02)
    added = np.zeros(len(loop))
    added[where] = 1.0
    spoilt = replace(loop, torque=loop.torque + torque * added, angle=loop.angle + angle * added)
    same, wrong = levelled(spoilt)
    assert np.flatnonzero(wrong).tolist() == where
    assert same.torque.max() == pytest.approx(60.0, abs=0.1)


def test_a_record_full_of_jumps_is_left_alone() -> None:
    rng = np.random.default_rng(4)
    loop = triangle(400, 0.1)

    jumpy = replace(loop, torque=loop.torque + 100 * (rng.random(400) < 0.3))
    assert levelled(jumpy)[0] is jumpy
