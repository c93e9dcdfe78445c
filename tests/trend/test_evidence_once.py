"""The loop prior counts once a drive, and what a test does not say is not believed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from hdprog.inference.information import Linearised
from hdprog.physics.parameters import NAMES
from hdprog.trend.fitting import fit_trend
from hdprog.trend.observation import Observations
from hdprog.trend.smoother import smooth
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.wear_coordinates import StatePrior, from_loop
from hdprog.trend.wear_prior import read_wear_prior
from tests.trend.stand_in import PRIOR

T_I = NAMES.index("T_i")


def change_found(precision: float, points: np.ndarray) -> float:
    """Change of log T_i over the tests, states smoothed with fixed hyperparameters.

    `precision` and `points` are what each test says of log T_i; the loadings are left open.
    """
    wear_prior = read_wear_prior()
    wide = wear_prior.loadings["T_i"].model_copy(update={"sd": 20.0})
    loadings = {**wear_prior.loadings, "T_i": wide}
    wear_prior = wear_prior.model_copy(update={"loadings": loadings})
    hours = np.linspace(0.0, 3000.0, points.size)
    timeline = Timeline(hours, hours == 0.0, np.zeros((points.size, 8)))
    values = Hyperparameters.of(np.zeros((1, len(HYPERPARAMETERS))), wear_prior)
    steps = Steps.of(timeline, values, StatePrior.of(PRIOR, wear_prior), wear_prior)
    along = np.eye(8)[T_I]
    loops = [
        Linearised(precision * np.outer(along, along), precision * point * along, 0.0)
        for point in points
    ]
    seen = Observations.of(loops, wear_prior.scales)
    states = smooth(steps, *seen.behind_scatter(values.scatter)[:2]).states
    return float(states[0, -1, T_I] - states[0, 0, T_I])


MEASURED = 4.0 / PRIOR.sd[T_I] ** 2  # the loop prior is twice as wide as the measurement
POINTS = PRIOR.mean[T_I] + np.linspace(0.0, -1.0, 40)


def test_forty_tests_do_not_shrink_the_trend() -> None:
    assert change_found(MEASURED, POINTS) == pytest.approx(-1.0, abs=0.03)


def test_a_posterior_used_as_data_would_shrink_it_by_a_fifth() -> None:
    """The control of the test above: what it guards against would be seen."""
    posterior = MEASURED + 1.0 / PRIOR.sd[T_I] ** 2
    shrunk = (MEASURED * POINTS + PRIOR.mean[T_I] / PRIOR.sd[T_I] ** 2) / posterior
    assert change_found(posterior, shrunk) == pytest.approx(-0.8, abs=0.03)


@dataclass(frozen=True)
class SilentTest:
    """A test that says nothing: its posterior is the loop prior itself."""

    service_hours: float
    posterior: np.ndarray
    event: str | None = None
    load_hours: float | None = None
    temperature_C: float | None = None
    exact: None = None

    def linearise(self, coordinates: np.ndarray) -> Linearised:
        return Linearised(np.zeros((8, 8)), np.zeros(8), 0.0)


def test_forty_silent_tests_add_nothing() -> None:
    """Less than a tenth of the prior's precision, in every coordinate.

    The standard deviation of 6 000 draws is known to 0.9 %; the bound lies five of its standard
    errors away from a posterior that equals the prior.
    """
    rng = np.random.default_rng(3)
    tests = [SilentTest(50.0 * number, PRIOR.sample(1000, rng)) for number in range(40)]
    trend = fit_trend(tests, PRIOR, read_wear_prior(), rng, quick=True)
    state = from_loop(trend.paths(np.array([0.0]), rng, 6000)[:, 0])
    expected = StatePrior.of(PRIOR, read_wear_prior())
    added = (expected.sd / state.std(axis=0)) ** 2 - 1
    # T_T's threshold is the same function of both coordinates, but flat where it is near zero.
    assert np.all(added < 0.1)
    deviates = trend.draws.flat
    assert np.all(np.abs(deviates.mean(axis=0)) < 0.25)
    assert np.all(np.abs(deviates.std(axis=0) - 1.0) < 0.25)
