"""Roots of covariances, and records that are next to without noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.covariance_root import root_of
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.sampling_plan import QUICK
from hdprog.physics.figures import FigureRequest
from tests.independent.loops import random_loop
from tests.independent.simulator import DriveParameters, MeasurementChain, true_figures

FIGURES = (
    FigureRequest("hysteresis_width_arcmin"),
    FigureRequest("lost_motion_arcmin"),
    FigureRequest("secant_stiffness_Nm_per_rad", 63.0),
)


def test_a_covariance_comes_back() -> None:
    rng = np.random.default_rng(1)
    half = rng.standard_normal((9, 9))
    covariance = half @ half.T
    root = root_of(covariance)
    np.testing.assert_allclose(root @ root.T, covariance, rtol=1e-12)
    assert (np.triu(root, 1) == 0).all()


def test_rounding_that_makes_a_direction_negative_leaves_it_the_least_spread() -> None:
    axes = np.linalg.qr(np.random.default_rng(2).standard_normal((4, 4)))[0]
    covariance = (axes * np.array([4.0, 1.0, 1e-3, -1e-17])) @ axes.T
    covariance[0, 1] += 1e-13
    root = root_of(covariance - 1e-15 * np.eye(4))
    assert np.isfinite(root).all()
    np.testing.assert_allclose(root @ root.T, covariance, atol=1e-12)


def test_a_record_without_noise_is_fitted() -> None:
    rng = np.random.default_rng(3)
    silent = MeasurementChain(torque_noise=0.0, angle_noise=0.0, torque_step=0.0, angle_step=0.0)
    record = random_loop(rng, "two-sided", samples=800, chain=silent)
    loop = Loop(torque=record.torque, angle=record.angle, time=record.time)
    drive = replace(Drive.default(), rated_torque=63.0, alpha_declared=True)
    posterior = fit_loop(loop, drive, rng, plan=QUICK)
    truth = true_figures(DriveParameters(**record.truth["parameters"]), secant_torque=63.0)
    for figure, value in posterior.figures(FIGURES).items():
        assert abs(float(np.median(value)) / truth[figure] - 1) < 1e-3, figure
