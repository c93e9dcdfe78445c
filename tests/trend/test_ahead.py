"""Paths past the last test, where they have a known course."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.physics.parameters import NAMES
from hdprog.trend.ahead import simulate_ahead, wear_out
from hdprog.trend.fitting import fit_trend
from hdprog.trend.kalman_filter import RATE
from hdprog.trend.state_space import Steps
from hdprog.trend.wear_prior import RateAhead, read_wear_prior
from tests.trend.stand_in import PRIOR, wearing_drive

B = NAMES.index("b")
FINE = 400
REACHED = np.linspace(1.0, 2.0, FINE + 1)  # expected wear, from one unit to two


def steps(draws: int, volatility: float = 0.0) -> Steps:
    """One coordinate of loading 1, whose wear is the clock's but for the rate's departure."""
    passed = np.tile(np.diff(REACHED), (draws, 1))
    lived = np.tile(np.diff(np.log(REACHED)), (draws, 1))
    nothing, one = np.zeros_like(passed), np.ones(1)
    return Steps(
        one * 0,
        one,
        one[None],
        one,
        one,
        (0.0, 1.0),
        np.zeros(FINE, dtype=bool),
        passed,
        nothing,
        passed,
        lived,
        volatility**2 * lived,
        nothing,
        nothing[..., None],
        nothing[..., None],
    )


def reached(of: Steps, rate: float, ahead: RateAhead, seed: int = 0) -> np.ndarray:
    draws = len(of.wear)
    carried = np.tile([1.0, 0.0, rate - 1.0], (draws, 1))
    assert carried[0, RATE] == rate - 1.0
    rng = np.random.default_rng(seed)
    return simulate_ahead(of, rng, (np.zeros((draws, 1)), carried), 0, ahead)[:, -1, 0]


@pytest.mark.parametrize("rate", [0.5, 1.0, 2.0])
def test_wear_goes_on_at_its_rate_without_drift_and_walk(rate: float) -> None:
    assert reached(steps(1), rate, RateAhead(spread=1.0, drift=0.0)) == pytest.approx(rate)


@pytest.mark.parametrize("rate", [0.5, 1.0, 2.0])
def test_a_drift_of_one_makes_the_rate_grow_with_expected_wear(rate: float) -> None:
    """The rate at expected wear u is then u times that at 1: its integral from 1 to 2 is 3/2."""
    found = reached(steps(1, volatility=1e-6), rate, RateAhead(spread=1.0, drift=1.0))
    assert found == pytest.approx(1.5 * rate, rel=1e-5)


def test_a_steady_pace_stays_steady_where_others_rise() -> None:
    assert reached(steps(1), 1.0, RateAhead(spread=1.25, drift=1.0)) == pytest.approx(1.0)


def test_the_walk_scatters_the_logarithm_of_the_rate() -> None:
    """Over the last step wear gains passed·exp(W), without it passed.

    4 000 draws; bounds of 4 standard errors, one false alarm in 10 000.
    """
    of = steps(4000, volatility=0.5)
    ahead = RateAhead(spread=2.0, drift=0.0)
    before = reached(replace(of, passed=of.passed * (np.arange(FINE) < FINE - 1)), 1.0, ahead)
    last = reached(of, 1.0, ahead) - before  # the same seed: the same paths
    walk = np.log1p(last / of.passed[0, -1])
    spread = 2.0 * 0.5 * np.sqrt(np.log(2.0))
    assert abs(np.median(walk)) < 4 * 1.25 * spread / np.sqrt(4000)
    assert abs(walk.std() / spread - 1) < 4 / np.sqrt(2 * 4000)


def test_the_shipped_prior_expects_wear_to_speed_up() -> None:
    assert read_wear_prior().rate_ahead.drift > 0


STRAIGHT = np.array([0.0, -0.03, 0.0, -2.6, 14.5, -0.02, -0.5, 0.14])  # per unit of wear
B, T_I = NAMES.index("b"), NAMES.index("T_i")
NOW = np.array([[11.3, 11.5, 7.5, np.log(20_000.0), 3.0, 0.1, np.log(90.0), np.log(0.07)]])
FLOOR = np.array([2_500.0])


def worn_out(units: list[float], direction: np.ndarray = STRAIGHT) -> np.ndarray:
    ahead = NOW[:, None] + np.array(units)[None, :, None] * direction
    return wear_out(NOW, ahead, FLOOR)[0]


def test_wear_of_all_parameters_ends_where_the_first_teeth_are_worn_out() -> None:
    end = worn_out([50.0])[0]
    assert np.exp(end[B]) == pytest.approx(2_500.0, rel=1e-6)
    units = np.log(20_000.0 / 2_500.0) / 2.6
    assert end == pytest.approx(NOW[0] + units * STRAIGHT, rel=1e-6)
    assert np.exp(end[T_I]) == pytest.approx(90.0 * (2_500.0 / 20_000.0) ** (0.5 / 2.6))


def test_far_from_its_end_wear_goes_on_as_it_does() -> None:
    assert worn_out([0.0, 1e-3]) == pytest.approx(NOW + np.outer([0.0, 1e-3], STRAIGHT), rel=1e-6)
    ways = np.diff(worn_out([0.0, 0.2, 0.4, 0.8, 1.6])[:, T_I] - NOW[0, T_I])
    assert (ways < 0).all()


def test_teeth_that_do_not_wear_set_no_end() -> None:
    direction = STRAIGHT.copy()
    direction[B] = 0.3
    ahead = NOW + np.outer([0.5, 5.0], direction)
    np.testing.assert_allclose(worn_out([0.5, 5.0], direction), ahead)


def test_a_walking_loading_spreads_the_state_as_its_integral_does() -> None:
    """20 000 draws: a standard deviation errs by half a per cent; 2.5 % once in a million."""
    still = steps(20_000)
    walk = 0.3**2 * still.lived[..., None]
    found = reached(replace(still, loading_walk=walk), 1.0, RateAhead(spread=1.0, drift=0.0))
    gone, gained = still.wear[0], walk[0, :, 0]
    beyond = np.cumsum(gone[::-1])[::-1] - gone
    variance = np.sum(gained * (beyond**2 + beyond * gone + gone**2 / 3))
    assert found.mean() == pytest.approx(1.0, abs=5 * np.sqrt(variance / 20_000))
    assert found.std() == pytest.approx(np.sqrt(variance), rel=0.025)


def test_a_drive_whose_pace_was_not_seen_is_not_expected_to_wear_ever_faster() -> None:
    """One test of a new drive: makers rate such gears for thousands of hours."""
    rng = np.random.default_rng(3)
    hours = np.array([0.0, 100.0, 1000.0])
    (first, second) = wearing_drive(rng, np.array([0.0, 0.1]), np.array([0.0, 300.0]))
    for tests, shown in (((first,), False), ((first, second), True)):
        trend = fit_trend(tests, PRIOR, read_wear_prior(), np.random.default_rng(1), quick=True)
        expected = trend.wear_prior.rate_ahead
        assert (trend._rate_ahead == expected) is shown
        if not shown:
            paths = trend.paths(hours, np.random.default_rng(2), 2000)
            gone = paths[:, 0, B] - paths[:, 1, B]
            # Half a unit of wear, by the middle loading of b, in a hundred hours.
            assert np.mean(gone > 1.3) < 0.2
    again = replace(second, event="replaced")
    trend = fit_trend(
        (first, again), PRIOR, read_wear_prior(), np.random.default_rng(1), quick=True
    )
    assert trend._rate_ahead.drift == 0.0
