"""Scores against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.forecast.scores import (
    alpha_lambda,
    coverage_range,
    covers,
    crps,
    cumulative_relative_accuracy,
    interval_probability,
    kupiec_p_value,
    log_score,
    probability_integral_transform,
    prognostic_horizon,
    relative_accuracy,
    sample_crps,
    transform_histogram,
)

HOURS = np.linspace(0.0, 1000.0, 2001)


def test_crps_of_a_certain_forecast_is_its_error() -> None:
    step = np.array([0.0, 400.0, 400.0, 1000.0])
    certain = np.array([0.0, 0.0, 1.0, 1.0])
    for truth, error in ((400.0, 0.0), (100.0, 300.0), (900.0, 500.0), (np.inf, 600.0)):
        assert crps(step, certain, truth) == pytest.approx(error)


def test_crps_of_a_uniform_forecast() -> None:
    """For F uniform on (0, 1) and truth y: y³/3 + (1 − y)³/3."""
    for truth in (0.0, 0.3, 1.0):
        expected = 1000.0 * (truth**3 + (1 - truth) ** 3) / 3
        assert crps(HOURS, HOURS / 1000.0, 1000.0 * truth) == pytest.approx(expected)


def test_crps_is_proper() -> None:
    """The true distribution, an exponential seen up to the horizon, beats neighbours of it."""
    truths = np.random.default_rng(1).exponential(500.0, 4000)
    mean = {
        scale: np.mean([crps(HOURS[::20], 1 - np.exp(-HOURS[::20] / scale), t) for t in truths])
        for scale in (300.0, 500.0, 800.0)
    }
    assert min(mean, key=mean.__getitem__) == 500.0


def test_transform_is_uniform_for_a_calibrated_forecast() -> None:
    """Kolmogorov's distance at 4 000 truths; 1.95/√n is passed once in 1 000."""
    rng = np.random.default_rng(2)
    values = np.sort(
        [
            probability_integral_transform(HOURS, 1 - np.exp(-HOURS / 500.0), truth, rng.uniform())
            for truth in rng.exponential(500.0, 4000)
        ]
    )
    distance = np.max(np.abs(values - (np.arange(4000) + 0.5) / 4000))
    assert distance < 1.95 / np.sqrt(4000)


def test_covers_with_open_ends() -> None:
    remaining = {0.05: 100.0, 0.25: 200.0, 0.75: 400.0, 0.95: None}
    assert covers(remaining, 0.05, 0.95, 5000.0)
    assert covers(remaining, 0.25, 0.75, 300.0)
    assert not covers(remaining, 0.25, 0.75, 500.0)
    assert not covers(remaining, 0.05, 0.95, 50.0)
    assert not covers({0.05: None, 0.95: None}, 0.05, 0.95, 500.0)


def test_kupiec() -> None:
    assert kupiec_p_value(90, 100, 0.9) == pytest.approx(1.0)
    # −2 log ratio at 80 of 100: 2·(80·log(8/9) + 20·log 2) = 8.880, beyond χ²₁ at 0.9971.
    assert kupiec_p_value(80, 100, 0.9) == pytest.approx(0.00288, abs=2e-5)
    assert 0.0 < kupiec_p_value(100, 100, 0.9) < 1e-4


def test_accuracy_measures() -> None:
    assert alpha_lambda(HOURS, HOURS / 1000.0, 500.0) == pytest.approx(0.2)
    assert relative_accuracy(80.0, 100.0) == pytest.approx(0.8)


def test_log_score_of_a_uniform_forecast_with_lumps() -> None:
    """A tenth at now, 0.6 spread over 1 000 h, 0.3 behind the horizon."""
    probability = 0.1 + 0.6 * HOURS / 1000.0
    assert log_score(HOURS, probability, 400.0) == pytest.approx(-np.log(0.6 / 1000.0))
    assert log_score(HOURS, probability, 0.0) == pytest.approx(-np.log(0.1))
    for late in (1000.0, np.inf):
        assert log_score(HOURS, probability, late) == pytest.approx(-np.log(0.3))
    grid, certain = np.array([0.0, 400.0, 500.0, 1000.0]), np.array([0.0, 0.0, 1.0, 1.0])
    assert log_score(grid, certain, 300.0) == np.inf
    assert log_score(grid, certain, 300.0, least=0.01) == pytest.approx(-np.log(1e-5))
    assert log_score(grid, certain, np.inf, least=0.01) == pytest.approx(-np.log(0.01))


def test_log_score_is_proper_with_censored_crossings() -> None:
    """The true exponential beats neighbours of it though 14 % of crossings are not seen."""
    truths = np.random.default_rng(3).exponential(500.0, 4000)
    mean = {
        scale: np.mean([log_score(HOURS, 1 - np.exp(-HOURS / scale), t) for t in truths])
        for scale in (400.0, 500.0, 620.0)
    }
    assert min(mean, key=mean.__getitem__) == 500.0


def test_crps_of_draws() -> None:
    assert sample_crps(np.array([3.0]), 5.0) == pytest.approx(2.0)
    # E|X − y| = 1, E|X − X'| = 1 for draws 0 and 2 at y = 1.
    assert sample_crps(np.array([2.0, 0.0]), 1.0) == pytest.approx(0.5)
    normal = np.random.default_rng(4).standard_normal(200_000)
    # Of a standard normal at zero: (√2 − 1)/√π; its Monte-Carlo error here is 0.002.
    expected = (np.sqrt(2.0) - 1.0) / np.sqrt(np.pi)
    assert sample_crps(normal, 0.0) == pytest.approx(expected, abs=0.008)


def test_probability_of_an_interval_takes_lumps_whole() -> None:
    assert interval_probability(np.array([0.0, 1.0]), 0.05, 0.95) == pytest.approx(0.9)
    # 0.3 behind the horizon: the late end is open, so the lump is inside.
    assert interval_probability(np.array([0.0, 0.7]), 0.05, 0.95) == pytest.approx(0.95)
    assert interval_probability(np.array([0.0, 0.02]), 0.05, 0.95) == pytest.approx(0.98)
    assert interval_probability(np.array([0.2, 1.0]), 0.05, 0.95) == pytest.approx(0.95)
    assert interval_probability(np.array([0.97, 1.0]), 0.05, 0.95) == pytest.approx(0.97)


def test_counted_intervals_of_calibrated_forecasts_hold_as_said() -> None:
    """4 000 exponential crossings cut at 400 h; four standard errors, 1 in 16 000."""
    hours = HOURS[HOURS <= 400.0]
    probability = 1 - np.exp(-hours / 500.0)
    quantile = {level: -500.0 * np.log(1 - level) for level in (0.25, 0.75)}
    remaining = {level: at if at <= 400.0 else None for level, at in quantile.items()}
    expected = interval_probability(probability, 0.25, 0.75)
    assert expected == pytest.approx(0.75)
    truths = np.random.default_rng(5).exponential(500.0, 4000)
    seen = np.where(truths < 400.0, truths, np.inf)
    share = np.mean([covers(remaining, 0.25, 0.75, at) for at in seen])
    assert share == pytest.approx(expected, abs=4 * np.sqrt(0.75 * 0.25 / 4000))


def test_coverage_range() -> None:
    """Clopper and Pearson's 1934 table: 0.025 = P(X ≥ held) at the low end, and so on."""
    from scipy.stats import binom

    low, high = coverage_range(8, 10)
    assert binom.sf(7, 10, low) == pytest.approx(0.025)
    assert binom.cdf(8, 10, high) == pytest.approx(0.025)
    assert coverage_range(3, 3) == (pytest.approx(0.025 ** (1 / 3)), 1.0)
    assert coverage_range(0, 3) == (0.0, pytest.approx(1 - 0.025 ** (1 / 3)))


def test_histogram_of_transforms() -> None:
    found = transform_histogram([0.05, 0.15, 0.15, 1.0], 10)
    assert found.counts.tolist() == [1, 2, 0, 0, 0, 0, 0, 0, 0, 1]
    assert found.low == 0
    assert found.inside
    assert not transform_histogram([0.05] * 20, 10).inside


def test_the_band_holds_all_bars_together() -> None:
    """Of 400 histograms of uniform transforms 5 % at most leave it; 8.5 % is 3 σ above that."""
    rng = np.random.default_rng(6)
    outside = [not transform_histogram(rng.uniform(size=60), 10).inside for _ in range(400)]
    assert np.mean(outside) < 0.085


def test_prognostic_horizon_and_cumulative_accuracy() -> None:
    origins = [0.0, 100.0, 300.0, 600.0]
    assert prognostic_horizon(origins, [False, True, False, True], 500.0) == 400.0
    assert prognostic_horizon(origins, [False, False, False, True], 500.0) is None
    assert cumulative_relative_accuracy([0.5, 1.0, 0.0]) == pytest.approx(0.5)
    assert np.isnan(cumulative_relative_accuracy([]))


def test_measures_are_progpys() -> None:
    """ProgPy 1.9 on profiles of draws, whose distribution function is a staircase."""
    reason = "ProgPy is not installed; `pip install progpy` compares the measures with its own"
    metrics = pytest.importorskip("progpy.metrics", reason=reason)
    predictors = pytest.importorskip("progpy.predictors", reason=reason)
    uncertain = pytest.importorskip("progpy.uncertain_data", reason=reason)
    rng, truth = np.random.default_rng(7), 1000.0
    profile = predictors.ToEPredictionProfile()
    accuracies, meets, origins = [], [], [0.0, 250.0, 500.0, 750.0]
    for now, spread in zip(origins, (400.0, 300.0, 60.0, 20.0), strict=True):
        draws = np.sort(now + np.abs(truth - now + spread * rng.standard_normal(200)))
        profile.add_prediction(now, uncertain.UnweightedSamples([{"limit": at} for at in draws]))
        stairs = np.repeat(draws, 2) + np.tile([-1e-9, 1e-9], draws.size)
        steps = np.repeat(np.arange(draws.size + 1), 2)[1:-1] / draws.size
        hours = np.concatenate([[now], stairs, [5000.0]])
        probability = np.concatenate([[0.0], steps, [1.0]])
        inside = alpha_lambda(hours, probability, truth, 0.2)
        remaining = 0.2 * (truth - now)
        bounds = {"limit": [truth - remaining, truth + remaining]}
        theirs = profile[now].percentage_in_bounds(bounds)["limit"]
        assert inside == pytest.approx(theirs, abs=1e-9)
        for beta in (inside - 0.01, inside + 0.01):
            passes = metrics.alpha_lambda(profile, {"limit": truth}, now, 0.2, beta)["limit"]
            assert passes == (inside >= beta)
        accuracies.append(relative_accuracy(float(draws.mean()), truth))
        meets.append(inside >= 0.5)
    theirs = metrics.cumulative_relative_accuracy(profile, {"limit": truth})["limit"]
    assert cumulative_relative_accuracy(accuracies) == pytest.approx(theirs, abs=1e-9)

    def criterion(remaining: object, true: dict[str, float]) -> dict[str, bool]:
        bounds = {"limit": [0.8 * true["limit"], 1.2 * true["limit"]]}
        return {"limit": remaining.percentage_in_bounds(bounds)["limit"] >= 0.5}  # type: ignore[attr-defined]

    theirs = metrics.prognostic_horizon(profile, criterion, {"limit": truth})["limit"]
    assert prognostic_horizon(origins, meets, truth) == pytest.approx(theirs, abs=1e-9)
    assert meets.index(True) > 0
