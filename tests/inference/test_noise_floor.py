"""The noise floor of a record is what neighbouring residuals scatter by, however it came about."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.measured_noise import noise_floor
from hdprog.inference.prepare import prepare
from hdprog.physics.parameters import FloatArray
from tests.independent.loops import record_loop
from tests.independent.simulator import POST_TEST, MeasurementChain, Segment

CYCLES = [Segment(target, 20.0) for target in (60.0, -60.0, 60.0, -60.0, 60.0)]
SLOPE = 4e-5 * np.ones(2000)  # rad/Nm
ANGLE, TORQUE = 5e-6, 0.2  # of which the angle moves by 8e-6


def floor(residual: FloatArray, rounding: tuple[float, float] = (0.0, 0.0)) -> float:
    return noise_floor(residual, None, SLOPE, (TORQUE, ANGLE), rounding)


def scatter(sd: float) -> FloatArray:
    return sd * np.random.default_rng(2).standard_normal(SLOPE.size)


def test_noise_of_the_torque_counts() -> None:
    both = float(np.hypot(ANGLE, 4e-5 * TORQUE))
    assert floor(scatter(both)) == pytest.approx(both, rel=0.05)


def test_what_torque_and_angle_do_together_is_no_noise() -> None:
    """The output moves: each channel scatters by itself, and the residual does not."""
    assert floor(scatter(ANGLE)) == pytest.approx(ANGLE, rel=0.05)


def test_a_slow_course_is_none() -> None:
    slow = 1e-4 * np.sin(np.linspace(0.0, 6.0, SLOPE.size))
    assert floor(slow + scatter(ANGLE)) == pytest.approx(ANGLE, rel=0.05)


def test_it_is_not_below_the_rounding_nor_above_both_channels() -> None:
    assert floor(np.zeros(SLOPE.size), (0.0, 3e-6)) == pytest.approx(3e-6)
    assert floor(scatter(1e-3)) == pytest.approx(np.hypot(ANGLE, 4e-5 * TORQUE))


@pytest.mark.parametrize("torque_noise", [0.02, 0.3])
def test_a_clean_record_is_fitted_down_to_it(torque_noise: float) -> None:
    chain = MeasurementChain(torque_noise, 1e-4, angle_noise=5e-6, angle_step=1e-8)
    rng = np.random.default_rng(4)
    record = record_loop(POST_TEST, CYCLES, 400, rng, chain=chain)
    prepared = prepare(Loop(record.torque, record.angle, record.time), Drive.default(), rng)
    likelihood = prepared.likelihood
    assert likelihood.blocks == 400
    left = likelihood.reduced.angle - likelihood.angle(prepared.starts[0].point[None])[0]
    assert np.std(left) == pytest.approx(prepared.noise_floor, rel=0.15)
