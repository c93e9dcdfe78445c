"""The other tooth angle by shifts from mode to mode, against full refits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.inference import tooth_angle
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.likelihood import COUNT
from hdprog.inference.posterior import Posterior
from hdprog.inference.sampling_plan import QUICK
from hdprog.inference.summarise import figure_requests, summarise
from hdprog.inference.tooth_angle import OTHER_ALPHA, assumed, first_order_shift
from hdprog.physics.drive_model import predict
from hdprog.physics.parameters import NAMES
from hdprog.reporting.weak_words import moved_by_angle
from hdprog.results import TestResult
from tests.inference.inverse import coordinates_of
from tests.inference.test_identification import NEW, PRIOR, loop_to
from tests.physics.table2 import POST_TEST

ASSUMED = replace(Drive.default(), rated_torque=63.0)


def fitted(truth: dict[str, float], alpha: float) -> tuple[Posterior, TestResult]:
    drive = replace(ASSUMED, alpha=alpha)
    posterior = fit_loop(
        loop_to(80.0, truth), drive, np.random.default_rng(0), prior=PRIOR, plan=QUICK
    )
    requests = figure_requests(drive, posterior.operation)
    return posterior, summarise(posterior, requests, "t01", {})


@pytest.mark.parametrize("truth", [POST_TEST, NEW], ids=["worn", "new"])
def test_it_agrees_with_a_full_refit(truth: dict[str, float]) -> None:
    """To 0.7 standard deviations of a number: 0.6 by the method, the rest Monte-Carlo error."""
    _, here = fitted(truth, ASSUMED.alpha)
    posterior, refit = fitted(truth, OTHER_ALPHA)
    other = here.other_tooth_angle
    assert other is not None
    assert refit.other_tooth_angle is None  # it is no default
    coordinates = posterior.coordinates
    moved = {name: np.array(levels[0.50]) for name, levels in other.parameters.items()}
    shifted = coordinates_of(posterior.prior, moved)
    deviation = (shifted - np.median(coordinates, axis=0)) / coordinates.std(axis=0)
    assert (np.abs(deviation) < 0.7).all(), dict(zip(NAMES, deviation.round(2), strict=True))
    for key, levels in other.figures.items():
        want = refit.figures[key]
        spread = (want[0.95] - want[0.05]) / 3.29
        assert abs(levels[0.50] - want[0.50]) < 0.7 * spread, key
        if "stiffness" in key:
            assert levels[0.50] == pytest.approx(want[0.50], rel=1e-3)
            assert levels[0.50] == pytest.approx(here.figures[key][0.50], rel=3e-3)
    assert other.parameters["K_W"][0.50] / here.parameters["K_W"].quantiles[0.50] == pytest.approx(
        (math.tan(OTHER_ALPHA) / math.tan(ASSUMED.alpha)) ** 2, rel=0.03
    )


@pytest.mark.filterwarnings("error")
def test_a_width_that_is_nothing_in_some_draws_is_moved_draw_by_draw(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A ratio of modes, one of them 0, gave 0 to 0 or no number, told as "less than 0.1 %"."""
    drive = replace(ASSUMED, rated_torque=20.0)
    record = loop_to(10.0, NEW)
    # Two seeds in nine leave so few effective draws that nothing is told, as below.
    here, there = (
        fit_loop(record, one, np.random.default_rng(5), prior=PRIOR, plan=QUICK)
        for one in (drive, replace(drive, alpha=OTHER_ALPHA))
    )
    requests = figure_requests(drive, here.operation)
    other = summarise(here, requests, "t01", {}).other_tooth_angle
    refit = summarise(there, requests, "t01", {}).figures["hysteresis_width_arcmin"]
    assert other is not None
    found = other.figures["hysteresis_width_arcmin"]
    assert found[0.05] == refit[0.05] == 0.0
    assert 0.3 < found[0.95] / refit[0.95] < 3.0

    # Of draws that are worth too few nothing is told, and the rest as before.
    monkeypatch.setattr(tooth_angle, "worth", lambda _: 1.0)
    fewer = summarise(here, requests, "t01", {})
    assert fewer.other_tooth_angle is not None
    untold = set(other.figures) - set(fewer.other_tooth_angle.figures)
    assert "hysteresis_width_arcmin" in untold
    assert {
        key: levels for key, levels in other.figures.items() if key not in untold
    } == fewer.other_tooth_angle.figures
    assert "hysteresis_width_arcmin" not in moved_by_angle(fewer)


def test_the_first_order_shift_leaves_a_loop_nearly_as_it_was() -> None:
    record = loop_to(100.0, POST_TEST)
    before = coordinates_of(PRIOR, POST_TEST)
    mapped = PRIOR.to_physical(before + first_order_shift(ASSUMED.alpha, OTHER_ALPHA)[:COUNT])
    there = {name: float(value) for name, value in mapped.items()}

    def change(parameters: dict[str, float]) -> float:
        moved = predict(record.torque, parameters, OTHER_ALPHA)
        return float(np.ptp(moved - predict(record.torque, POST_TEST, ASSUMED.alpha)))

    assert change(there) < 0.05 * change(POST_TEST)


def test_only_a_default_is_an_assumption() -> None:
    assert assumed(math.radians(30.0), declared=False)
    assert not assumed(math.radians(30.0), declared=True)
    assert not assumed(math.radians(20.0), declared=False)
