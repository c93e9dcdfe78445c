"""What is said of a trend beside its numbers."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hdprog.physics.parameters import NAMES
from hdprog.trend.fitting import _warnings
from hdprog.trend.fleet import FleetPrior
from hdprog.trend.state_space import HYPERPARAMETERS
from hdprog.trend.summary import not_reproduced
from hdprog.trend.trend import Trend
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_prior import read_wear_prior


def said(events: list[str | None], loads: list[float] | None = None) -> tuple[str, ...]:
    """Of tests 500 h apart, before each of which an event may have been, by hours of load."""
    tests: list[Any] = [
        SimpleNamespace(
            service_hours=500.0 * at, event=one, load_hours=None if loads is None else loads[at]
        )
        for at, one in enumerate(events)
    ]
    trend: Any = SimpleNamespace(
        tests=tests,
        clock=ServiceClock.of(tests),
        wear_prior=read_wear_prior(),
        mode=SimpleNamespace(converged=True),
        draws=SimpleNamespace(converged=True),
    )
    return _warnings(trend, cast("Any", SimpleNamespace(sampled=True, converged=True)), 0.0)


@pytest.mark.parametrize(("since", "words"), [(1, "one test only"), (3, "3 tests only")])
def test_tests_before_a_replacement_are_not_of_the_drive_that_is_there(
    since: int, words: str
) -> None:
    found = " ".join(said([None] * 6 + ["replaced"] + [None] * (since - 1)))
    assert words in found
    assert "was replaced" in found
    assert said([None] * 6) == ()


def test_a_load_of_late_that_is_not_the_mean_is_told() -> None:
    """Twice the torque since the last test but one, and the forecast goes on with the mean."""
    level, late = [0.0, 500, 1000, 1500, 2000], [0.0, 200, 400, 600, 2000]
    assert said([None] * 5, level) == said([None] * 5) == ()
    (warning,) = said([None] * 5, late)
    assert "wore it 2.8 times as fast as its mean load" in warning
    assert warning.endswith("--load 1.41.")
    (warning,) = said([None] * 5, [0.0, 700, 1400, 2000, 2000])
    assert "ran without load" in warning


def test_what_carries_a_hyperparameter_is_told_of_itself() -> None:
    """A fleet knows pace and exponent by their sum: tests that know the pace know both."""
    covariance = np.eye(len(HYPERPARAMETERS) + len(NAMES))
    covariance[0, 1] = covariance[1, 0] = 0.95
    mean = np.zeros(len(covariance))
    rng = np.random.default_rng(0)
    deviates = rng.standard_normal((4000, len(HYPERPARAMETERS)))
    deviates[:, 0] *= 0.05
    for fleet, named in ((FleetPrior(("a",), mean, covariance), False), (None, True)):
        prior = read_wear_prior() if fleet is None else read_wear_prior().learnt_from(fleet)
        trend: Any = SimpleNamespace(
            met=SimpleNamespace(deviates=deviates), wear_prior=prior, _in_use=HYPERPARAMETERS
        )
        carried = Trend.carried_by_prior(trend)
        assert "wear_rate" not in carried
        assert ("clock_exponent" in carried) == named
        assert "volatility" in carried


def test_a_figure_that_is_0_in_every_draw_is_reproduced_by_0_alone() -> None:
    """The width where the teeth never slip."""
    key, zeros = "hysteresis_width_arcmin", np.zeros((50, 2))
    own = [np.zeros(50), np.zeros(50)]
    assert not_reproduced(key, own, zeros) == ()
    [found] = not_reproduced(key, own, zeros + np.array([0.0, 0.1]))
    assert (found.tests, found.worst) == ((1,), 1)
