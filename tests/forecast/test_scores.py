"""Scores against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.forecast.scores import (
    alpha_lambda,
    covers,
    crps,
    kupiec_p_value,
    probability_integral_transform,
    relative_accuracy,
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
