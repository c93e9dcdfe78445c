"""Paths past the last test, where they have a known course."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.ahead import left_worn_out, simulate_ahead, worn_ahead
from hdprog.trend.fitting import fit_trend
from hdprog.trend.kalman_filter import RATE
from hdprog.trend.state_space import Steps
from hdprog.trend.trend import Trend
from hdprog.trend.wear_prior import HeavyTailed, RateAhead, read_wear_prior
from tests.hasty import HASTY
from tests.trend.stand_in import PRIOR, SimulatedLoop, wearing_drive

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


@pytest.mark.parametrize("rate", [0.5, 1.0, 5.0])
def test_the_walk_scatters_the_logarithm_of_the_rate(rate: float) -> None:
    """Over the last step wear gains exp(W) times what it did, by as much as the tests may show.

    A departure from the clock's rate that spreads by 0.5 makes a rate of five times that spread by
    0.1 of itself. 4 000 draws; bounds of 4 standard errors, one false alarm in 10 000.
    """
    of = steps(4000, volatility=0.5)
    ahead = RateAhead(spread=2.0, drift=0.0)
    not_last = of.wear * (np.arange(FINE) < FINE - 1)
    before = reached(replace(of, wear=not_last, passed=not_last), rate, ahead)
    last = reached(of, rate, ahead) - before  # the same seed: the same paths
    walk = np.log(last / of.wear[0, -1] / rate)
    spread = 2.0 * 0.5 * np.sqrt(np.log(2.0)) / rate
    assert abs(np.median(walk)) < 4 * 1.25 * spread / np.sqrt(4000)
    assert abs(walk.std() / spread - 1) < 4 / np.sqrt(2 * 4000)


@pytest.mark.parametrize("rate", [0.5, 1.0, 2.0])
def test_what_has_levelled_off_is_not_set_going_again(rate: float) -> None:
    """The clock wears no more; its departure, if it has one, goes on and may grow on."""
    level = replace(steps(1, volatility=1e-6), wear=np.zeros((1, FINE)))
    found = reached(level, rate, RateAhead(spread=1.0, drift=1.0))
    assert found == pytest.approx(1.5 * max(rate - 1.0, 0.0), abs=1e-9, rel=1e-5)


def test_a_drive_wears_faster_by_its_own_loadings() -> None:
    """What does not wear is not set going by what does, and what wears twice as fast goes on so."""
    one = steps(1, volatility=1e-6)
    none, ahead = np.zeros((1, FINE, 2)), RateAhead(spread=1.0, drift=1.0)
    two = replace(one, initial_mean=np.zeros(2), direction=np.ones(2), own=none, loading_walk=none)
    start = (np.zeros((1, 2)), np.array([[0.0, 2.0, 0.0, 0.0]]))
    found = simulate_ahead(two, np.random.default_rng(0), start, 0, ahead)[0, -1]
    assert found == pytest.approx([0.0, 3.0], rel=1e-5)


def test_the_shipped_prior_expects_wear_to_speed_up() -> None:
    assert read_wear_prior().rate_ahead.drift > 0


STRAIGHT = np.array([0.0, -0.03, 0.0, -2.6, 14.5, -0.02, -0.5, 0.14])  # per unit of wear
B, T_I = NAMES.index("b"), NAMES.index("T_i")
ENDS = {
    name: HeavyTailed(median=median, log_scale=1e-9) for name, median in (("b", 0.1), ("T_i", 0.4))
}


def of_size(medians: FloatArray) -> Steps:
    """Steps of a drive whose loop prior has these medians, in wear coordinates."""
    return replace(steps(1), initial_mean=medians, initial_variance=np.full(8, 1e6))


def worn_out(units: list[float], direction: FloatArray, medians: FloatArray) -> FloatArray:
    """Changes (times, 8) after so many units of wear of a drive at its prior's medians."""
    now = medians[None]
    ahead = now[:, None] + np.array(units)[None, :, None] * direction
    return worn_ahead(of_size(medians), now, ahead, ENDS, np.random.default_rng(0))[0][0] - now


MIDDLE = PRIOR.mean


def test_teeth_and_preload_each_come_to_an_end_of_their_own() -> None:
    """What wears along with them goes as far as they do."""
    (end,) = worn_out([50.0], STRAIGHT, MIDDLE)
    assert end[[B, T_I]] == pytest.approx(np.log([0.1, 0.4]), rel=1e-4)
    with_preload = np.isin(NAMES, ("T_i", "mu"))
    assert end[~with_preload] == pytest.approx(np.log(0.1) / -2.6 * STRAIGHT[~with_preload])
    assert end[with_preload] == pytest.approx(np.log(0.4) / -0.5 * STRAIGHT[with_preload])


def test_far_from_its_end_wear_goes_on_as_it_does() -> None:
    found = worn_out([0.0, 1e-4], STRAIGHT, MIDDLE)
    assert found == pytest.approx(np.outer([0.0, 1e-4], STRAIGHT), rel=1e-3)
    assert (np.diff(worn_out([0.0, 0.2, 0.4, 0.8, 1.6], STRAIGHT, MIDDLE)[:, T_I]) < 0).all()


def test_teeth_at_their_end_do_not_hold_up_the_loss_of_preload() -> None:
    worn, sound = STRAIGHT.copy(), STRAIGHT.copy()
    worn[B], sound[B] = -100.0, 0.0
    found = [worn_out([0.5], direction, MIDDLE)[:, T_I] for direction in (worn, sound)]
    np.testing.assert_allclose(*found)


def test_what_rises_has_no_end() -> None:
    direction = np.abs(STRAIGHT)
    np.testing.assert_allclose(worn_out([0.5], direction, MIDDLE)[0], 0.5 * direction)


def test_wear_ends_alike_for_a_drive_of_any_size() -> None:
    """A CSF-14's first teeth are a sixth as stiff as a CSF-25's when both are as new."""
    smaller = MIDDLE + np.log(1 / 6)
    units = [0.2, 0.8, 3.0]
    np.testing.assert_allclose(
        worn_out(units, STRAIGHT, smaller), worn_out(units, STRAIGHT, MIDDLE)
    )


def left_of(present: float) -> FloatArray:
    """(4000,) draws of what is left at the end of a b of so much of its prior's median."""
    belief, rng = read_wear_prior().worn_out["b"], np.random.default_rng(5)
    return left_worn_out(belief, np.full(4000, np.log(present)), rng)


def test_the_end_of_wear_is_drawn_below_what_there_is() -> None:
    belief = read_wear_prior().worn_out["b"]
    assert np.median(left_of(1.0)) == pytest.approx(belief.median, rel=0.06)
    assert (left_of(0.05) < 1.0).all()


def test_teeth_worn_beyond_all_that_were_tested_wear_on() -> None:
    """With a Gaussian tail a hundredth of the median was to lose a tenth more, no half."""
    for present in (0.03, 0.01, 0.003):
        assert np.median(left_of(present)) < 0.5
        assert np.mean(left_of(present) < 0.25) > 0.2


def test_a_heavy_tail_is_students() -> None:
    belief = HeavyTailed(median=0.1, log_scale=0.5)
    student = stats.t(2, loc=np.log(0.1), scale=0.5)
    values = np.linspace(-12.0, 4.0, 9)
    np.testing.assert_allclose(belief.below(values), student.cdf(values), rtol=1e-9)
    levels = np.array([1e-6, 0.05, 0.5, 0.9])
    np.testing.assert_allclose(belief.log_at(levels), student.ppf(levels), rtol=1e-9)


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
        trend = _hasty_trend(tests)
        expected = trend.wear_prior.rate_ahead
        assert (trend._rate_ahead == expected) is shown
        if not shown:
            paths = trend.paths(hours, np.random.default_rng(2), 2000)
            gone = paths[:, 0, B] - paths[:, 1, B]
            # Half a unit of wear, by the middle loading of b, in a hundred hours.
            assert np.mean(gone > 1.3) < 0.2
    again = replace(second, event="replaced")
    assert _hasty_trend((first, again))._rate_ahead.drift == 0.0


def _hasty_trend(tests: Sequence[SimulatedLoop]) -> Trend:
    rng = np.random.default_rng(1)
    return fit_trend(tests, PRIOR, read_wear_prior(), rng, quick=True, joint_effort=HASTY)


def test_random_steps_shrink_as_much_as_the_way_does_near_its_end() -> None:
    """A step of a thousandth of a unit more, against what is said to be left of one."""
    now, units = MIDDLE[None], np.array([0.0, 0.5, 1.0, 2.0])
    rows = [now + np.outer(units + more, STRAIGHT) for more in (0.0, 1e-3)]
    same = [np.random.default_rng(0) for _ in rows]
    (at, left), (beside, _) = (
        worn_ahead(of_size(MIDDLE), now, row[None], ENDS, rng)
        for row, rng in zip(rows, same, strict=True)
    )
    for shown in (B, T_I):
        step = (beside - at)[0, :, shown] / (1e-3 * STRAIGHT[shown])
        assert left[0, :, shown] == pytest.approx(step, rel=0.01)
    assert left[0, 0] == pytest.approx(np.ones(8))
