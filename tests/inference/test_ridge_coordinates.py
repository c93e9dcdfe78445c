"""The sampling coordinates: a bijection whose Jacobian is right."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained
from hdprog.physics.parameters import BY_NAME


@pytest.mark.parametrize(
    ("alpha_deg", "largest"), [(20.0, None), (30.0, None), (30.0, 60.0), (30.0, 9.0)]
)
def test_round_trip_and_jacobian(alpha_deg: float, largest: float | None) -> None:
    alpha = math.radians(alpha_deg)
    prior = read_prior_file("csf-25-80").prior(None)
    draws = prior.sample(300, np.random.default_rng(3))
    frame = (alpha, prior.softplus_scale, largest)
    ridge = from_unconstrained(draws, *frame)
    back, log_jacobian = to_unconstrained(ridge, *frame)
    np.testing.assert_allclose(back, draws, atol=1e-10)
    step = 1e-5
    derivative = np.empty((300, 8, 8))
    for index in range(8):
        shift = step * np.eye(8)[index]
        up, _ = to_unconstrained(ridge + shift, *frame)
        down, _ = to_unconstrained(ridge - shift, *frame)
        derivative[:, :, index] = (up - down) / (2 * step)
    difference = np.linalg.slogdet(derivative)[1] - log_jacobian
    # Right up to one constant, which no posterior sees.
    assert np.ptp(difference) < 1e-6


def test_the_fall_of_friction_is_that_up_to_the_largest_torque() -> None:
    """Where T_i lies inside the record, c moves T_i and log m alone, beyond it ξ as before."""
    prior = read_prior_file("csf-25-80").prior(None)
    alpha, c, T_i, mu = math.radians(30), 5, 6, 7
    point = prior.mean[None, :].copy()
    point[:, T_i] = np.log(40.0)
    moved = point + 0.1 * np.eye(8)[c] - 0.1 * np.eye(8)[T_i]  # P stays
    before, after = (
        from_unconstrained(one, alpha, prior.softplus_scale, 60.0) for one in (point, moved)
    )
    np.testing.assert_allclose(np.flatnonzero(np.abs(after - before)[0] > 1e-12), [5])
    fall = np.exp(point[0, c] + point[0, mu]) * 40.0 / 60.0 - math.cos(alpha) * np.exp(point[0, mu])
    assert before[0, 6] == pytest.approx(fall / 0.02)
    point[:, T_i] = np.log(70.0)
    np.testing.assert_allclose(
        from_unconstrained(point, alpha, prior.softplus_scale, 60.0),
        from_unconstrained(point, alpha, prior.softplus_scale),
        rtol=1e-12,
    )


def test_a_threshold_beyond_the_record_moves_nothing_else() -> None:
    prior = read_prior_file("csf-25-80").prior(None)
    frame = (math.radians(30), prior.softplus_scale, 9.0)
    point = prior.mean[None, :].copy()
    point[:, 4] = BY_NAME["T_T"].to_coordinate(np.array([9.5]), prior.softplus_scale)
    moved = point + 0.5 * np.eye(8)[4]
    before, after = from_unconstrained(point, *frame), from_unconstrained(moved, *frame)
    np.testing.assert_allclose(np.flatnonzero(np.abs(after - before)[0] > 1e-12), [4])
    inside = point - 0.5 * np.eye(8)[4]
    assert abs(from_unconstrained(inside, *frame) - before)[0, 0] > 1e-3


def test_positions_that_name_no_parameters_have_no_density() -> None:
    prior = read_prior_file("csf-25-80").prior(None)
    ridge = from_unconstrained(prior.mean[None, :], math.radians(30), prior.softplus_scale)
    ridge[:, 6] = 1e3  # xi above m: friction would be negative
    assert to_unconstrained(ridge, math.radians(30), prior.softplus_scale)[1] == -np.inf
