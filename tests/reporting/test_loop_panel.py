"""Axes of a loop's picture: the readings are seen where the fit misses them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.physics.parameters import FloatArray
from hdprog.reporting.figures.loop_panel import PanelScales
from hdprog.reporting.geometry import straightened
from hdprog.results import TestResult
from tests.reporting import drives


@pytest.fixture(name="good", scope="module")
def good_fixture() -> TestResult:
    return drives.one_test(1, 900.0, 0.3, drives.drive(), samples=2400)


def measured_as(test: TestResult, angle: FloatArray) -> TestResult:
    fit = test.fit
    return replace(test, fit=replace(fit, angle=angle, residual=angle - fit.fitted))


def inside(test: TestResult, limits: tuple[float, float]) -> float:
    """Share of the readings within the axes."""
    seen = straightened(test.fit, test.fit.angle, test.fit.torque)
    return float(np.mean((seen > limits[0]) & (seen < limits[1])))


def test_readings_that_the_fit_misses_are_within_the_axes(good: TestResult) -> None:
    fit = good.fit
    width = float(np.ptp(straightened(fit, fit.fitted, fit.torque)))
    wave = 1e-3 * width * np.sin(np.arange(fit.angle.size) / 9.0)
    missed = measured_as(good, fit.fitted + wave)
    scales = PanelScales.of((missed,))
    assert inside(missed, scales.straightened_fits) < 0.7  # what hid them
    assert inside(missed, scales.straightened) > 0.95
    # The overlay, which draws no readings, keeps the scale of the curves.
    assert scales.straightened_fits == PanelScales.of((good,)).straightened_fits


def test_a_good_record_is_drawn_to_its_curve_and_spikes_do_not_flatten_it(
    good: TestResult,
) -> None:
    curve = PanelScales.of((good,))
    assert curve.straightened == curve.straightened_fits
    spiked = good.fit.angle.copy()
    spiked[::60] += 1.0
    flat = PanelScales.of((measured_as(good, spiked),)).straightened
    assert np.ptp(flat) < 1.1 * np.ptp(curve.straightened)
