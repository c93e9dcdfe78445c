"""Of more cycles than a fit can follow in detail the first are fitted, and rightly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.first_stretches import MOST_STRETCHES, first_stretches
from hdprog.data.loop import Loop
from hdprog.data.turning_points import turning_points
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.sampling_plan import QUICK
from hdprog.physics.drive_model import predict
from hdprog.physics.figures import figures, standard_requests
from tests.physics.table2 import POST_TEST

DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
PRIOR = read_prior_file("csf-25-80").prior(None)
NOISE = 6e-6


def cycling(cycles: int, samples: int, seed: int) -> Loop:
    rng = np.random.default_rng(seed)
    corners = [0.0, *([80.0, -80.0] * cycles), 0.0]
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)))])
    torque = np.interp(np.linspace(0.0, travelled[-1], samples), travelled, corners)
    angle = predict(torque, POST_TEST) + NOISE * rng.standard_normal(samples)
    return Loop(torque, angle, np.linspace(0.0, 6000.0, samples))


def beginning(loop: Loop) -> tuple[Loop, str | None]:
    points = turning_points(loop.torque, time=loop.time)
    first, kept, remark = first_stretches(loop, points)
    assert kept[-1] == len(first) - 1
    return first, remark


def test_the_first_cycles_of_many_are_kept_and_it_is_said() -> None:
    loop = cycling(60, 12_000, 1)
    first, remark = beginning(loop)
    assert remark is not None
    assert "first 20 cycles" in remark
    assert f"{len(first)} of 12000 readings" in remark
    assert np.array_equal(first.torque, loop.torque[: len(first)])
    assert first.time is not None
    assert first.time.size == len(first)


@pytest.mark.parametrize(("cycles", "samples"), [(20, 12_000), (60, 600)])
def test_what_can_be_followed_is_fitted_whole(cycles: int, samples: int) -> None:
    loop = cycling(cycles, samples, 1)
    first, remark = beginning(loop)
    assert remark is None
    assert first is loop
    assert 2 * cycles + 1 <= MOST_STRETCHES or samples <= 600


@pytest.mark.parametrize("seed", [0, 1])
def test_sixty_cycles_lead_to_the_truth_from_every_seed(seed: int) -> None:
    """Five standard deviations; a wrong mode was off by more than seven, and called converged."""
    posterior = fit_loop(
        cycling(60, 30_000, 7), DRIVE, np.random.default_rng(seed), prior=PRIOR, plan=QUICK
    )
    requests = standard_requests(posterior.operation)
    draws = posterior.figures(requests)
    exact = {name: np.array([value]) for name, value in POST_TEST.items()}
    truth = figures(requests, exact, posterior.operation)
    for key in ("hysteresis_width_arcmin", "lost_motion_arcmin"):
        away = float(truth[key][0] - draws[key].mean()) / float(draws[key].std())
        assert abs(away) < 5.0
    assert np.sqrt(np.mean(posterior.record_residual**2)) < 1.1 * NOISE
    assert any("first 20 cycles" in text for text in posterior.warnings)
