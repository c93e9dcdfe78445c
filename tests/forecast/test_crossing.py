"""First crossings against known first-passage laws."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from hdprog.config import Limit
from hdprog.errors import BadInputError
from hdprog.forecast.backtest import score_crossing
from hdprog.forecast.crossing import Crossing, first_crossing, forecast_hours
from hdprog.forecast.limits import Margins

DRIFT, SPREAD, START = 1.0, 2.0, 20.0


def normal(value: np.ndarray) -> np.ndarray:
    return 0.5 * (1 + np.vectorize(math.erf)(value / math.sqrt(2)))


def inverse_gaussian(hours: np.ndarray) -> np.ndarray:
    """First passage of a Wiener process with drift (Cox & Miller, 1965, section 5.7)."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        root = SPREAD * np.sqrt(hours)
        late = np.exp(2 * DRIFT * START / SPREAD**2) * normal(-(START + DRIFT * hours) / root)
        found = normal((DRIFT * hours - START) / root) + late
    return np.where(hours > 0, found, 0.0)


def wiener(hours: np.ndarray, draws: int, rng: np.random.Generator) -> Margins:
    passed = np.diff(hours, prepend=hours[0])
    step = -DRIFT * passed + SPREAD * np.sqrt(passed) * rng.standard_normal((draws, hours.size))
    wander = np.broadcast_to(SPREAD**2 * passed, step.shape)
    return Margins(START + np.cumsum(step, axis=1), wander)


def test_a_coarse_grid_gives_the_exact_first_passage() -> None:
    """5 000 paths on 15 times; 4.5 standard errors at each: a false alarm in 10 000."""
    hours = np.linspace(0.0, 70.0, 15)
    margin = wiener(hours, 5000, np.random.default_rng(1))
    found = first_crossing(hours, [margin])
    exact = inverse_gaussian(hours)
    error = 4.5 * np.sqrt(exact * (1 - exact) / 5000) + 1e-12
    assert np.all(np.abs(found.probability - exact) < error)
    uncorrected = (np.minimum.accumulate(margin.margin, axis=1) <= 0).mean(axis=0)
    assert np.max(exact - uncorrected) > 0.05  # what the correction is there for


def test_never_crossing_mass_is_kept() -> None:
    margin = np.full((100, 3), 1.0)
    margin[:40, 1:] = -1.0
    found = first_crossing(np.array([0.0, 1.0, 2.0]), [Margins(margin, np.zeros((100, 3)))])
    assert found.probability.tolist() == pytest.approx([0.0, 0.4, 0.4])
    assert found.quantile(0.5) is None
    assert found.quantile(0.2) == pytest.approx(0.5)


def test_a_distribution_rests_on_the_paths_that_are_left() -> None:
    """A crossing held for impossible costs as much as so few paths can tell."""
    hours = np.linspace(0.0, 100.0, 51)
    margin = np.full((1000, 51), -1.0)
    margin[:10] = 5.0 - 0.2 * hours  # all cross at 25 h
    limits = [Margins(margin, np.zeros_like(margin))]
    found = first_crossing(hours, limits, survived_so_far=True)
    assert (found.paths, found.upto(60.0).paths) == (10, 10)
    assert first_crossing(hours, limits).paths == 1000
    limit = Limit("lost_motion_arcmin", 2.0, "above")
    scored = score_crossing(limit, found, 60.0, 100.0, True, 0.5, 100.0)
    assert scored.log_score == pytest.approx(-math.log(1 / 10 / 100))


def test_what_may_be_past_the_limit_now_is_told_unless_it_is_known_not_to_be() -> None:
    """Three in ten paths lie past the limit now."""
    margin = np.full((100, 2), 1.0)
    margin[:30] = -1.0
    margin[30:65, 1] = -1.0
    limits = [Margins(margin, np.zeros((100, 2)))]
    found = first_crossing(np.array([0.0, 1.0]), limits)
    assert not found.already
    assert found.probability.tolist() == pytest.approx([0.3, 0.65])
    running = first_crossing(np.array([0.0, 1.0]), limits, survived_so_far=True)
    assert running.probability.tolist() == pytest.approx([0.0, 0.5])


@pytest.mark.parametrize(("past", "expected"), [(70, [0.0, 0.5]), (100, [1.0, 1.0])])
def test_what_is_known_outweighs_most_paths_but_not_all(past: int, expected: list[float]) -> None:
    margin = np.full((100, 2), 1.0)
    margin[:past] = -1.0
    margin[past : past + 15, 1] = -1.0
    still = Margins(margin, np.zeros((100, 2)))
    found = first_crossing(np.array([0.0, 1.0]), [still], survived_so_far=True)
    assert found.already
    assert found.probability.tolist() == pytest.approx(expected)


@pytest.mark.parametrize("share", [0.1, 0.45, 0.55])
def test_the_first_of_all_is_never_safer_than_one_of_them(share: float) -> None:
    """Paths that are past one limit now go on to pass the other one, and no others do."""
    hours, past = np.array([0.0, 10.0, 20.0]), round(200 * share)
    one, other = np.full((200, 3), 1.0), np.full((200, 3), 1.0)
    one[:past] = -1.0
    other[: past // 2, 2] = -1.0
    still = np.zeros((200, 3))
    limits = [Margins(one, still), Margins(other, still)]
    first = first_crossing(hours, limits)
    for limit in limits:
        single = first_crossing(hours, [limit])
        assert np.all(first.probability >= single.probability)
        assert first.already or not single.already


def test_past_the_limit_now() -> None:
    margin = np.full((100, 2), -1.0)
    margin[80:, 0] = 1.0
    found = first_crossing(np.array([500.0, 600.0]), [Margins(margin, np.zeros((100, 2)))])
    assert found.already
    assert found.probability.tolist() == pytest.approx([0.8, 1.0])
    assert found.quantile(0.5) == 500.0
    assert found.quantile(0.9) == pytest.approx(550.0)


def test_the_first_of_two_limits_is_the_earlier_one() -> None:
    rng = np.random.default_rng(2)
    hours = np.linspace(0.0, 60.0, 40)
    one, other = wiener(hours, 3000, rng), wiener(hours, 3000, rng)
    first = first_crossing(hours, [one, other]).probability
    each = [first_crossing(hours, [margin]).probability for margin in (one, other)]
    assert np.all(first >= np.maximum(*each) - 1e-12)
    # Independent paths: 1 − (1 − F)², to 4.5 standard errors.
    assert np.allclose(first, 1 - (1 - each[0]) * (1 - each[1]), atol=4.5 * 0.5 / np.sqrt(3000))
    # A limit that is never met changes nothing.
    far = dataclasses.replace(one, margin=one.margin + 1e6)
    assert np.allclose(first_crossing(hours, [one, far]).probability, each[0])


def test_a_limit_given_twice_is_met_as_often_as_once() -> None:
    """One random path leads to both: its touches between the times count once."""
    hours = np.linspace(0.0, 70.0, 15)
    margin = wiener(hours, 500, np.random.default_rng(3))
    once, twice = (first_crossing(hours, limits) for limits in ([margin], [margin, margin]))
    np.testing.assert_array_equal(once.probability, twice.probability)


def test_hours_are_dense_near_now_and_end_at_the_horizon() -> None:
    hours = forecast_hours(1000.0, 20_000.0)
    assert hours[0] == 1000.0
    assert hours[-1] == 20_000.0
    steps = np.diff(hours)
    assert np.all(steps > 0)
    assert steps[0] < steps[-1] / 50
    assert forecast_hours(0.0, 10.0, shutdown=30.0)[-1] == 30.0


@pytest.mark.parametrize("horizon", [1000.0, 999.0, float("nan")])
def test_a_horizon_that_is_not_ahead_is_refused(horizon: float) -> None:
    with pytest.raises(BadInputError, match="horizon"):
        forecast_hours(1000.0, horizon)


def test_cut_at_the_horizon() -> None:
    found = Crossing(
        np.array([0.0, 10.0, 20.0]), np.array([0.0, 0.4, 0.8]), already=False, paths=1000
    )
    cut = found.upto(15.0)
    assert cut.hours.tolist() == [0.0, 10.0, 15.0]
    assert cut.probability.tolist() == pytest.approx([0.0, 0.4, 0.6])
    assert cut.quantile(0.7) is None
