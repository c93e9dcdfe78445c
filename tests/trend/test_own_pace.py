"""A parameter that leaves the common pace is followed, and goes on at the pace it has come to."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.inference.information import Linearised
from hdprog.physics.parameters import NAMES
from hdprog.trend.kalman_filter import RATE
from hdprog.trend.observation import Observations
from hdprog.trend.smoother import Course, smooth
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.wear_coordinates import StatePrior
from hdprog.trend.wear_prior import WearPrior, read_wear_prior

STATE = StatePrior(np.zeros(8), np.ones(8))
HOURS = np.linspace(0.0, 2000.0, 9)
B, T_I = NAMES.index("b"), NAMES.index("T_i")
READ = 0.004


def followed(wear_prior: WearPrior, late: float) -> Course:
    """Course of tests whose preload wears `late` times as fast in their second half."""
    begins = np.arange(HOURS.size) == 0
    timeline = Timeline(HOURS, begins, np.zeros((HOURS.size, 8)))
    values = Hyperparameters.of(np.zeros((1, len(HYPERPARAMETERS))), wear_prior)
    steps = Steps.of(timeline, values, STATE, wear_prior)
    wear = np.cumsum(steps.wear[0])
    states = wear[:, None] * wear_prior.loading_mean
    gone = np.where(HOURS > 1000.0, late, 1.0) * steps.wear[0]
    states[:, T_I] = np.cumsum(gone) * wear_prior.loading_mean[T_I]
    loops = [Linearised(np.eye(8) / READ**2, state / READ**2, 0.0) for state in states]
    seen = Observations.of(loops, wear_prior.scales)
    return smooth(steps, *seen.behind_scatter(values.scatter)[:2])


def last_pace(course: Course, wear_prior: WearPrior) -> np.ndarray:
    """Change of each coordinate per unit of wear after the last test, over its expectation."""
    pace = course.carried[0, :8] + course.carried[0, RATE] * wear_prior.loading_mean
    return pace[[B, T_I]] / wear_prior.loading_mean[[B, T_I]]


@pytest.mark.parametrize("late", [0.4, 1.0, 2.5])
def test_preload_goes_on_at_its_own_pace_and_teeth_at_theirs(late: float) -> None:
    shipped = read_wear_prior()
    teeth, preload = last_pace(followed(shipped, late), shipped)
    # Scatter of remounting leaves some of the way to the new pace open.
    assert preload == pytest.approx(late, abs=0.1 + 0.4 * abs(late - 1))
    assert teeth == pytest.approx(1.0, abs=0.1)


def test_without_a_pace_of_its_own_it_would_go_on_as_in_the_mean() -> None:
    """The planted fault: loadings that stay as they are."""
    shipped = read_wear_prior()
    still = shipped.own_pace.model_copy(update={"spread": 0.0})
    held = shipped.model_copy(update={"own_pace": still})
    common = followed(held, 2.5)
    np.testing.assert_allclose(common.carried[0, :8], common.loadings[0], rtol=1e-9)
    _, preload = last_pace(common, held)
    assert preload < 1.9 < last_pace(followed(shipped, 2.5), shipped)[1]


def test_preload_and_friction_wander_by_a_volatility_of_their_own() -> None:
    shipped = read_wear_prior()
    timeline = Timeline(HOURS, np.arange(HOURS.size) == 0, np.zeros((HOURS.size, 8)))
    deviates = np.zeros((2, len(HYPERPARAMETERS)))
    deviates[1, HYPERPARAMETERS.index("preload_volatility")] = 1.0
    steps = Steps.of(timeline, Hyperparameters.of(deviates, shipped), STATE, shipped)
    grown = np.exp(2 * shipped.preload_volatility.log_sd)
    times = [grown if name in ("T_i", "mu") else 1.0 for name in NAMES]
    for usual, wider in (steps.own, steps.loading_walk):
        np.testing.assert_allclose(wider, usual * times)


def test_teeth_that_hardly_wander_leave_preload_free_to() -> None:
    shipped = read_wear_prior()
    quiet = shipped.own_volatility.model_copy(update={"median": 1e-6})
    teeth, preload = last_pace(
        followed(shipped.model_copy(update={"own_volatility": quiet}), 2.5), shipped
    )
    assert preload > 1.9
    assert teeth == pytest.approx(1.0, abs=0.1)
