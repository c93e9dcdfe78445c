"""The sampling coordinates: a bijection whose Jacobian is right."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.ridge_coordinates import from_unconstrained, to_unconstrained


@pytest.mark.parametrize("alpha_deg", [20.0, 30.0])
def test_round_trip_and_jacobian(alpha_deg: float) -> None:
    alpha = math.radians(alpha_deg)
    prior = read_prior_file("csf-25-80").prior(None)
    draws = prior.sample(300, np.random.default_rng(3))
    ridge = from_unconstrained(draws, alpha, prior.softplus_scale)
    back, log_jacobian = to_unconstrained(ridge, alpha, prior.softplus_scale)
    np.testing.assert_allclose(back, draws, atol=1e-10)
    step = 1e-5
    derivative = np.empty((300, 8, 8))
    for index in range(8):
        shift = step * np.eye(8)[index]
        up, _ = to_unconstrained(ridge + shift, alpha, prior.softplus_scale)
        down, _ = to_unconstrained(ridge - shift, alpha, prior.softplus_scale)
        derivative[:, :, index] = (up - down) / (2 * step)
    difference = np.linalg.slogdet(derivative)[1] - log_jacobian
    # Right up to one constant, which no posterior sees.
    assert np.ptp(difference) < 1e-6


def test_positions_that_name_no_parameters_have_no_density() -> None:
    prior = read_prior_file("csf-25-80").prior(None)
    ridge = from_unconstrained(prior.mean[None, :], math.radians(30), prior.softplus_scale)
    ridge[:, 6] = 1e3  # xi above m: friction would be negative
    assert to_unconstrained(ridge, math.radians(30), prior.softplus_scale)[1] == -np.inf
