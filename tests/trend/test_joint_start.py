"""The climb to the joint mode begins in the better of two valleys, wherever the means lie."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from hdprog.trend.joint_start import best_start
from hdprog.trend.relinearise import JointPrior
from hdprog.trend.ridge_map import RidgeMap
from hdprog.trend.wear_coordinates import from_loop, to_loop
from tests.trend.stand_in import ALPHA, NEW, PRIOR, Information

SD = np.ones(8)
PRECISION = 25.0


@dataclass(frozen=True)
class TwoModes:
    """Evidence with one mode at −2 and another at 2 of the first coordinate, lower by `lower`."""

    lower: float
    posterior: np.ndarray
    exact: object | None
    service_hours: float = 0.0
    event: str | None = None
    load_hours: float | None = None
    temperature_C: float | None = None

    def linearise(self, coordinates: np.ndarray) -> Information:
        mode = np.zeros(8)
        mode[0] = -2.0 if coordinates[0] < 0 else 2.0
        mode[4] = coordinates[4]  # the threshold's coordinate is curved: nothing is known of it
        precision = PRECISION * np.eye(8)
        precision[4, 4] = 0.0
        off = coordinates - mode
        height = -0.5 * PRECISION * float(off @ off) - (self.lower if mode[0] > 0 else 0.0)
        return Information(precision, precision @ mode, height)


def evidence(lower: float, exact: object | None) -> list[TwoModes]:
    """Two tests, six of ten draws about the mode at 2."""
    rng = np.random.default_rng(3)
    draws = from_loop(np.zeros((200, 8))) + rng.standard_normal((200, 8)) / np.sqrt(PRECISION)
    draws[:, 0] += np.where(np.arange(200) % 10 < 6, 2.0, -2.0)
    return [TwoModes(lower, to_loop(draws), exact) for _ in range(2)]


@pytest.mark.parametrize(
    ("lower", "exact", "mode"),
    [(5.0, True, -2.0), (-5.0, True, 2.0), (5.0, None, 2.0)],
    ids=["far from the means", "near the means", "Gaussian loops are climbed from the means"],
)
def test_the_start_with_most_evidence_is_taken(
    lower: float, exact: object | None, mode: float
) -> None:
    tests = evidence(lower, exact)
    means = np.stack([from_loop(test.posterior).mean(axis=0) for test in tests])
    assert (means[:, 0] > 0).all()
    centre = np.zeros((2, 8))
    centre[:, 4] = means[:, 4]
    found = best_start(tests, means, JointPrior(centre, 1e-4 * np.eye(16)), SD, ALPHA, 10.0)
    assert found.points[:, 0] == pytest.approx(mode, abs=0.1)


HARD = from_loop(NEW)
SOFT = RidgeMap(HARD, ALPHA, PRIOR.softplus_scale).with_cup(HARD[0] - 0.5)


@dataclass(frozen=True)
class TwoCups(TwoModes):
    """Evidence with one mode at a hard cup, and another at a soft one on the same ridge."""

    def linearise(self, coordinates: np.ndarray) -> Information:
        soft = coordinates[0] < HARD[0] - 0.25
        mode = to_loop(SOFT if soft else HARD)
        mode[4] = coordinates[4]
        precision = PRECISION * np.eye(8)
        precision[4, 4] = 0.0
        off = coordinates - mode
        height = -0.5 * PRECISION * float(off @ off) - (self.lower if soft else 0.0)
        return Information(precision, precision @ mode, height)


@pytest.mark.parametrize(("lower", "cup"), [(-5.0, SOFT[0]), (5.0, HARD[0])])
def test_another_cup_is_looked_at_though_no_draw_has_it(lower: float, cup: float) -> None:
    draws = to_loop(HARD + np.random.default_rng(4).standard_normal((200, 8)) * 0.02)
    tests = [TwoCups(lower, draws, True) for _ in range(2)]
    means, centre = np.stack([HARD, HARD]), np.stack([HARD, HARD])
    prior = JointPrior(centre, 1e-4 * np.eye(16))
    found = best_start(tests, means, prior, SD, ALPHA, PRIOR.softplus_scale)
    assert found.points[:, 0] == pytest.approx(cup, abs=0.05)
