"""The oracle of the fleets' benchmark knows what can be known, and its checks notice a fault."""

import numpy as np
import pytest
from scipy.special import gammaincc
from scipy.stats import invgauss

from tests.benchmarks.prognostics.fleets import HORIZON, NOW, first_crossing, fleet
from tests.benchmarks.prognostics.laws import LAWS, Gamma, Smooth, Wiener
from tests.benchmarks.prognostics.method import GRID, given_survival, of_crossings
from tests.benchmarks.prognostics.oracle import oracle
from tests.benchmarks.prognostics.scoring import Summary, score, summarised

FLEETS = 20  # of each law


def quantile(probability: np.ndarray, level: float) -> float:
    return float(np.interp(level, probability, GRID)) - NOW


def test_wiener_known_but_for_its_course_is_the_inverse_gaussian_law():
    law = Wiener(pace=1.2, scatter=1e-6, noise=1e-6, shape=0.1)
    reached = 0.45
    readings = np.array([0.0, 0.1, 0.22, 0.3, reached])
    found = oracle(law, readings, GRID, np.random.default_rng(0)).probability
    distance = 1.0 - reached
    shape = (distance / law.shape) ** 2
    expected = invgauss(distance / law.pace / shape, scale=1000.0 * shape)
    np.testing.assert_allclose(found, expected.cdf(GRID - NOW), atol=1e-4)
    for level in (0.05, 0.5, 0.95):
        assert quantile(found, level) == pytest.approx(expected.ppf(level), rel=5e-3)


def test_gamma_known_but_for_its_course_is_the_incomplete_gamma_function():
    law = Gamma(pace=1.0, scatter=1e-6, noise=0.002, shape=40.0)
    readings = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    found = oracle(law, readings, GRID, np.random.default_rng(0)).probability
    # The noise of the last reading, a fifteenth of what is left to come, blurs it a little.
    expected = gammaincc(law.shape * (GRID[1:] - NOW) / 1000.0, law.shape * 0.6)
    np.testing.assert_allclose(found[1:], expected, atol=0.01)


@pytest.mark.parametrize("law", [law for law in LAWS if issubclass(law.kind, Smooth)])
def test_curves_cross_where_their_formula_says(law):
    population = law.population(np.random.default_rng(1))
    deviates = np.random.default_rng(2).standard_normal((20, population.deviates))
    hours = np.arange(0.0, HORIZON + 1.0)
    paths = population.level(deviates, hours)
    expected = population.crossing(deviates)
    found = np.array([first_crossing(path) for path in paths])
    np.testing.assert_allclose(found, np.where(expected > HORIZON, np.inf, expected), atol=0.01)


@pytest.fixture(scope="module")
def oracles() -> list[tuple[np.ndarray, float, float]]:
    rng = np.random.default_rng(3)
    found = []
    for law in LAWS:
        for number in range(FLEETS):
            one = fleet(law, 0, number, 1)
            unit = one.new[0]
            told = oracle(one.population, unit.readings, GRID, rng)
            assert told.worth > 500
            found.append((told.probability, unit.crossing, rng.uniform()))
    return found


def summary_of(oracles, changed=lambda probability: probability) -> Summary:
    scores = [score(*one) for one in oracles]
    return summarised([score(changed(p), at, u) for p, at, u in oracles], scores)


def test_the_oracle_is_calibrated(oracles):
    # False alarm: 5 % for the band of the histogram and for the range of the coverage each.
    found = summary_of(oracles)
    assert found.histogram.inside
    assert found.range_90[0] < 0.9 < found.range_90[1]
    assert found.ratio == pytest.approx(1.0)


def test_too_narrow_a_forecast_is_noticed(oracles):
    def narrowed(probability: np.ndarray) -> np.ndarray:
        centre = float(np.interp(0.5, probability, GRID))
        return np.interp(centre + 2.0 * (GRID - centre), GRID, probability, left=0.0)

    found = summary_of(oracles, narrowed)
    assert not found.covers
    assert found.range_90[1] < 0.87
    assert not found.histogram.inside


def test_a_forecast_too_late_is_not_as_sharp_as_the_oracle(oracles):
    found = summary_of(oracles, lambda p: np.interp(GRID - 150.0, GRID, p, left=0.0))
    assert not found.sharp


def test_the_same_fleet_is_drawn_again():
    one, again = fleet(LAWS[1], 3, 7, 1), fleet(LAWS[1], 3, 7, 1)
    np.testing.assert_array_equal(one.others, again.others)
    assert one.new[0].crossing == again.new[0].crossing > NOW


def test_crossings_of_the_past_are_left_out_and_never_stays():
    found = of_crossings(np.array([NOW - 1.0, NOW + 100.0, np.inf, np.inf]))
    assert found[0] == 0.0
    assert found[-1] == pytest.approx(1.0 / 3.0)
    np.testing.assert_allclose(given_survival(np.linspace(0.5, 0.75, GRID.size))[-1], 0.5)
