"""A fleet whose drives wear at a steady pace can say so, and one that does not cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.physics.parameters import NAMES
from hdprog.trend.fleet import FleetPrior, Said
from hdprog.trend.hyperparameters import HyperparameterDraws
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.steady_evidence import log_likelihood, steady_said
from hdprog.trend.steady_pace import (
    CURVATURE,
    RATE_VOLATILITY,
    SteadySaid,
    Told,
    all_steady,
    is_steady,
    pooled_deviates,
    pooled_fleet,
    steady_chance,
)
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import read_wear_prior
from tests.benchmarks.degradation.series import Series, Study, readings, state_prior, wear_prior
from tests.benchmarks.prognostics.scalar_trend import ScalarTrend, fit_scalar_trend, fleet_prior

COUNT = len(HYPERPARAMETERS)
SIZE = COUNT + len(NAMES)
WITHIN = read_wear_prior().within_fleet.scales(SIZE)
STUDY = Study("test", "", "", "", "", 0.0, 1.0, 1000.0, 5)
HOURS = np.array([1.0, *np.arange(100.0, 1000.0, 100.0)])


def mixed(chance: float) -> FleetPrior:
    """A fleet whose steady drives wear at another pace than the others."""
    rng = np.random.default_rng(1)
    root = 0.3 * rng.standard_normal((SIZE, SIZE)) + np.eye(SIZE)
    steady = FleetPrior(("a",), np.full(SIZE, 2.0), 0.25 * np.eye(SIZE))
    return FleetPrior(("a", "b"), rng.standard_normal(SIZE), root @ root.T, steady, chance)


def test_the_places_are_those_of_the_names() -> None:
    assert HYPERPARAMETERS[CURVATURE] == "clock_curvature"
    assert HYPERPARAMETERS[RATE_VOLATILITY] == "rate_volatility"


@pytest.mark.parametrize("drives", [1, 3, 40])
def test_drives_whose_tests_leave_no_doubt_are_counted(drives: int) -> None:
    """Beta(½, ½) and so many successes: a mean of (drives + ½)/(drives + 1)."""
    chance, own = steady_chance(np.full(drives, 50.0))
    assert chance == pytest.approx((drives + 0.5) / (drives + 1), abs=0.01)
    np.testing.assert_allclose(own, 1.0, atol=1e-6)
    against, own = steady_chance(np.full(drives, -50.0))
    assert against == pytest.approx(0.5 / (drives + 1), abs=0.01)
    np.testing.assert_allclose(own, 0.0, atol=1e-6)


def test_drives_whose_tests_fit_both_alike_say_nothing() -> None:
    chance, own = steady_chance(np.zeros(5))
    assert chance == pytest.approx(0.5)
    np.testing.assert_allclose(own, 0.5)


def test_a_steady_pace_has_no_bend_and_no_random_change() -> None:
    prior = read_wear_prior().learnt_from(all_steady(SIZE))
    standard = np.random.default_rng(2).standard_normal((500, COUNT))
    values = Hyperparameters.of(standard, prior)
    shipped = Hyperparameters.of(standard, read_wear_prior())
    assert not values.rate_volatility.any()
    assert not values.clock.curvature.any()
    np.testing.assert_allclose(values.clock.exponent, shipped.clock.exponent)
    np.testing.assert_allclose(values.volatility, shipped.volatility)


def test_a_steady_pace_is_that_of_every_coordinate() -> None:
    """No loading walks by itself either, where those of the shipped prior do."""
    tests = readings(Series("", HOURS, HOURS / 1000.0), HOURS.size, state_prior())
    standard = np.random.default_rng(2).standard_normal((50, COUNT))
    walks = []
    for prior in (read_wear_prior().learnt_from(all_steady(SIZE)), read_wear_prior()):
        timeline, _ = Timeline.of(tests, ServiceClock.of(tests), prior)
        values = Hyperparameters.of(standard, prior)
        steps = Steps.of(timeline, values, StatePrior.of(state_prior(), prior), prior)
        walks.append(steps.loading_walk[:, 1:])
    assert not walks[0].any()
    assert (walks[1].sum(axis=1) > 0.0).all()


def test_the_fleets_share_of_drives_is_steady_and_the_rest_as_the_others_say() -> None:
    """100 000 draws: shares and means within five standard errors."""
    fleet = mixed(0.7)
    found = pooled_deviates(np.random.default_rng(3).standard_normal((100_000, COUNT)), fleet)
    steady = is_steady(found)
    assert steady.mean() == pytest.approx(0.7, abs=5 * np.sqrt(0.21 / 1e5))
    np.testing.assert_allclose(found[~steady].mean(axis=0), fleet.mean[:COUNT], atol=0.06)
    covariance = fleet.covariance[:COUNT, :COUNT]
    np.testing.assert_allclose(np.cov(found[~steady].T), covariance, atol=0.12)
    kept = [at for at in range(COUNT) if at not in (CURVATURE, RATE_VOLATILITY)]
    np.testing.assert_allclose(found[steady][:, kept].mean(axis=0), 2.0, atol=0.02)
    np.testing.assert_allclose(found[steady][:, kept].std(axis=0), 0.5, rtol=0.02)


def test_rows_of_a_rare_steady_pace_are_drawn_from_its_own_prior() -> None:
    """100 000 draws, a fifth steady, correlated: means within five standard errors."""
    rng = np.random.default_rng(6)
    root = 0.3 * rng.standard_normal((SIZE, SIZE)) + np.eye(SIZE)
    fleet = replace(mixed(0.2), steady=FleetPrior(("a",), np.full(SIZE, 2.0), root @ root.T))
    found = pooled_deviates(rng.standard_normal((100_000, COUNT)), fleet)
    kept = [at for at in range(COUNT) if at not in (CURVATURE, RATE_VOLATILITY)]
    steady = found[is_steady(found)][:, kept]
    spread = np.sqrt(np.diag(root @ root.T))[kept]
    off = (steady.mean(axis=0) - 2.0) / spread
    np.testing.assert_allclose(off, 0.0, atol=5 / np.sqrt(len(steady)))
    np.testing.assert_allclose(steady.std(axis=0), spread, rtol=0.04)


def test_loadings_are_those_of_either_pace() -> None:
    shipped = read_wear_prior()
    prior = shipped.learnt_from(mixed(0.5))
    standard = np.random.default_rng(4).standard_normal((4000, COUNT))
    values = Hyperparameters.of(standard, prior)
    steady = is_steady(prior.deviates(standard))
    expected = shipped.loading_mean + 2.0 * shipped.loading_sd
    np.testing.assert_allclose(values.loading_mean[steady], np.tile(expected, (steady.sum(), 1)))
    np.testing.assert_allclose(values.loading_sd[steady][0], 0.5 * shipped.loading_sd)
    assert np.isfinite(values.loading_mean).all()


def test_runs_that_do_not_tell_leave_the_fleet_as_it_was() -> None:
    said = [Said(np.eye(SIZE), np.full(SIZE, 0.5))] * 2
    plain = FleetPrior.of(["a", "b"], said, WITHIN)
    fleet = pooled_fleet(["a", "b"], [Told(one, None) for one in said], WITHIN)
    assert fleet.steady is None
    np.testing.assert_array_equal(fleet.mean, plain.mean)
    standard = np.random.default_rng(5).standard_normal((10, COUNT))
    mean, root = plain.of_hyperparameters
    np.testing.assert_array_equal(pooled_deviates(standard, fleet), mean + standard @ root.T)


def test_what_a_drive_says_of_a_steady_pace_counts_as_far_as_its_pace_is() -> None:
    """One of two drives surely changes its pace: the other alone tells how steady ones wear."""
    nothing = Said(np.zeros((SIZE, SIZE)), np.zeros(SIZE))
    one, other = (Said(100 * np.eye(SIZE), np.full(SIZE, 100 * at)) for at in (1.0, -3.0))
    told = [Told(nothing, SteadySaid(one, 40.0)), Told(nothing, SteadySaid(other, -40.0))]
    fleet = pooled_fleet(["steady", "not"], told, WITHIN)
    assert fleet.steady is not None
    assert fleet.chance == pytest.approx(0.5, abs=0.01)
    assert (fleet.steady.mean > 0.0).all()


def test_the_integral_of_a_density_is_found() -> None:
    """A unit Gaussian, without its constant, times the likelihood N(y | z, ½)."""
    rng, size, y = np.random.default_rng(6), 9, 0.7

    def log_density(points: np.ndarray) -> np.ndarray:
        return np.asarray(-0.5 * np.sum(points**2 + (points - y) ** 2 / 0.5, axis=1))

    draws = y / 1.5 + np.sqrt(0.5 / 1.5) * rng.standard_normal((4, 100, 20, size))
    known = HyperparameterDraws(draws, 1.0, 1000.0, 1000.0, True)
    exact = 0.5 * size * (np.log(2 * np.pi) + np.log(0.5 / 1.5) - y**2 / 1.5)
    found, error = log_likelihood(log_density, known, rng)
    assert found == pytest.approx(exact, abs=5 * error)
    assert 0.01 < error < 0.04  # weights with a coefficient of variation of 0.4 to 1.5


def test_log_odds_that_hang_on_a_few_proposals_are_not_told() -> None:
    """The planted fault: a density that is far narrower than the draws that it is said to have."""
    rng, size = np.random.default_rng(9), COUNT
    draws = rng.standard_normal((4, 100, 20, size))
    known = HyperparameterDraws(draws, 1.0, 1000.0, 1000.0, True)

    def narrow(points: np.ndarray) -> np.ndarray:
        return np.asarray(-0.5 * np.sum((points / 0.05) ** 2, axis=1))

    def nothing(deviates: np.ndarray, *_: object) -> np.ndarray:
        return np.zeros((len(deviates), len(NAMES)))

    assert log_likelihood(narrow, known, rng)[1] > 0.5
    shipped = read_wear_prior()
    for density, told in ((narrow, False), (lambda z: -0.5 * np.sum(z**2, axis=1), True)):
        found = steady_said(shipped, lambda _, d=density: d, nothing, known, np.zeros(size), rng)
        assert (found is not None) == told


def unit(values: np.ndarray, seed: int) -> ScalarTrend:
    rng = np.random.default_rng(seed)
    noisy = values + 0.01 * rng.standard_normal(values.size)
    series = readings(Series("", HOURS[: values.size], noisy), values.size, state_prior())
    return fit_scalar_trend(series, wear_prior(STUDY), rng)


def test_steady_fleets_say_so_and_sharpen_the_forecast() -> None:
    """Straight lines of three paces; a fourth seen up to 400 h fails at 1 000 h."""
    rng = np.random.default_rng(7)
    fits = [unit(pace * HOURS / 1000.0, number) for number, pace in enumerate((0.9, 1.0, 1.1))]
    taught = fleet_prior(wear_prior(STUDY), fits, rng)
    assert taught.fleet is not None
    assert taught.fleet.chance > 0.7
    early = readings(Series("", HOURS[:5], HOURS[:5] / 1000.0), 5, state_prior())
    hours = np.linspace(400.0, 4000.0, 200)
    spreads = []
    for prior in (taught, wear_prior(STUDY)):
        found = fit_scalar_trend(early, prior, rng).crossing(hours, rng, 2000)
        low, middle, high = (found.quantile(level) or 4000.0 for level in (0.05, 0.5, 0.95))
        spreads.append(high - low)
        if prior is taught:
            assert middle == pytest.approx(1000.0, abs=120.0)
    assert spreads[0] < 0.6 * spreads[1]


def test_units_that_change_their_pace_speak_against_it() -> None:
    """The planted fault: wear that waits, comes and stops, which no power of the hours follows."""
    rng = np.random.default_rng(8)
    bent = 0.8 * np.clip((HOURS - 300.0) / 200.0, 0.0, 1.0)
    steady = unit(0.8 * HOURS / 1000.0, 1).told(rng).steady
    changed = unit(bent, 2).told(rng).steady
    assert steady is not None
    assert changed is not None
    assert steady.log_odds > 0.0 > changed.log_odds
