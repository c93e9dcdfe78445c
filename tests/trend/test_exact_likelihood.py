"""What a fitted loop says exactly agrees with its linearisation near the mode."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.trend.loop_evidence import FittedLoop
from tests.trend.friction_beside import TRUTH, WIDEST, evidence, followed_by, likelihood


@pytest.fixture(scope="module")
def loop() -> FittedLoop:
    return evidence(0.5 * WIDEST, 0.0, 3, followed_by(likelihood(0.0, 1)))


def test_nuisances_follow_the_exact_likelihood(loop: FittedLoop) -> None:
    """Steps of a spread change both log densities alike, to a third of what they fall."""
    at = np.append(TRUTH, 0.5)
    own = loop.nuisances(at)
    lower = np.linalg.cholesky(np.linalg.inv(own.precision))
    for column in lower.T:
        moved = own.mean + np.outer([-1.0, 0.0, 1.0], column)
        here = np.repeat(at[None], 3, axis=0)
        exact = loop.log_likelihood(here, moved) - 0.5 * np.sum(moved**2, axis=1)
        assert exact[1] == pytest.approx(exact.max(), abs=0.1)
        fall = exact[1] - (exact[0] + exact[2]) / 2
        assert fall == pytest.approx(0.5, abs=0.2)


def test_a_draw_of_nuisances_has_their_density(loop: FittedLoop) -> None:
    own = loop.nuisances(np.append(TRUTH, 0.5))
    rng = np.random.default_rng(1)
    departure = 1e-3 * rng.standard_normal((2000, TRUTH.size + 1))
    drawn = own.draw(departure, rng.standard_normal((2000, own.mean.size)))
    squares = -2 * own.log_density(departure, drawn)
    # Chi-squared with k degrees: its mean is known to sqrt(2k/2000).
    k = own.mean.size
    assert squares.mean() == pytest.approx(k, abs=5 * np.sqrt(2 * k / 2000))


@pytest.mark.parametrize("amplitude", [-0.3, 0.0, 0.4])
def test_an_amplitude_goes_on_straight_where_its_coordinate_ends(
    loop: FittedLoop, amplitude: float
) -> None:
    """Also below zero, where the effect's own coordinate has no place."""
    at = np.append(TRUTH, amplitude)
    own = loop.nuisances(at)
    near = np.stack([at, at, at])
    near[:, -1] += [-0.05, 0.0, 0.05]
    exact = loop.log_likelihood(near, np.repeat(own.mean[None], 3, axis=0))
    assert np.isfinite(exact).all()
    assert (np.diff(exact) > 0).all()  # up towards the truth
