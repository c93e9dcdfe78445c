"""The bound of the fleets' benchmark weighs laws and populations as brute force does."""

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import ks_2samp

from tests.benchmarks.prognostics.evidence import unit_evidence
from tests.benchmarks.prognostics.fleets import NOW, SEEN, TEST_HOURS, first_crossing, fleet
from tests.benchmarks.prognostics.law_not_told import (
    Sample,
    law_chances,
    mean_forecast,
    sample,
    with_new_unit,
)
from tests.benchmarks.prognostics.laws import LAWS, PLANNED_HOURS, Gamma, Smooth, Wiener
from tests.benchmarks.prognostics.method import GRID
from tests.benchmarks.prognostics.oracle import oracle
from tests.benchmarks.prognostics.populations import COORDINATES, populations_at

UNITS = 200_000
NOISY = np.array([0.5, 0.2, 1.8, -0.3])  # a point of the normal space


def units(population, hours, rng):
    """Figures (units, times) at the tests, drawn from the population."""
    if isinstance(population, Smooth):
        return population.level(rng.standard_normal((UNITS, population.deviates)), hours)
    steps = np.diff(hours / PLANNED_HOURS, prepend=0.0)
    deviates = rng.standard_normal(UNITS)
    if isinstance(population, Gamma):
        sizes = population.sizes(deviates) / population.shape
        shapes = population.shape * steps
        return np.cumsum(rng.gamma(shapes, size=(UNITS, steps.size)), axis=1) * sizes[:, None]
    assert isinstance(population, Wiener)
    wander = population.shape * np.sqrt(steps) * rng.standard_normal((UNITS, steps.size))
    return np.cumsum(population.drifts(deviates)[:, None] * steps + wander, axis=1)


@pytest.mark.parametrize("new", [False, True])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_evidence_of_a_unit_is_that_of_brute_force(law, new):
    rng = np.random.default_rng(1)
    populations = populations_at(law, NOISY[None])
    population = populations[0]
    hours = TEST_HOURS[:SEEN] if new else TEST_HOURS
    path = population.paths(rng, np.arange(0.0, TEST_HOURS[-1] + 1.0))
    readings = path[hours.astype(int)] + population.noise * rng.standard_normal(hours.size)
    found = unit_evidence(law, readings, new, rng)(populations)[0]
    figures = units(population, hours, rng)
    if new:
        figures = figures[figures[:, -1] < 1.0]
    missed = (readings - figures) / population.noise
    said = -0.5 * np.sum(missed**2 + np.log(2 * np.pi * population.noise**2), axis=1)
    expected = logsumexp(said) - np.log(said.size)
    weight = np.exp(said - logsumexp(said))
    error = np.sqrt(np.sum(weight**2))
    assert error < 0.09
    assert found == pytest.approx(expected, abs=3.0 * error + 0.08)


def test_lives_of_fast_units_are_counted():
    # One in several has failed by now: its chance of living is not to be left out.
    law = LAWS[0]
    populations = populations_at(law, np.array([[4.5, 1.0, 1.0, 1.0]]))
    population, rng = populations[0], np.random.default_rng(2)
    hours = np.arange(0.0, NOW + 1.0)
    lived = np.mean(
        [not np.isfinite(first_crossing(population.paths(rng, hours))) for _ in range(3000)]
    )
    assert lived < 0.9
    readings = 0.3 * TEST_HOURS[:SEEN] / NOW  # so slow that the readings say it lived
    told, untold = (unit_evidence(law, readings, new, rng)(populations)[0] for new in (True, False))
    assert told - untold == pytest.approx(-np.log(lived), abs=0.05)


@pytest.mark.parametrize("law", [LAWS[1], LAWS[3]], ids=lambda law: law.name)
def test_evidence_of_a_law_is_the_mean_over_its_populations(law):
    rng = np.random.default_rng(3)
    one = fleet(law, 1, 0, 1)
    evidence = [unit_evidence(law, values, False, rng) for values in one.others]
    found = sample(law, evidence, rng).log_weight
    drawn = populations_at(law, rng.standard_normal((3000, COORDINATES)))
    expected = evidence[0](drawn)
    means = [logsumexp(log) - np.log(log.size) for log in (found, expected)]
    assert means[0] == pytest.approx(means[1], abs=0.12)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_the_normal_space_holds_the_populations_of_the_law(law):
    rng = np.random.default_rng(4)
    drawn = [law.population(rng) for _ in range(1500)]
    here = populations_at(law, rng.standard_normal((1500, COORDINATES)))
    for name in ("pace", "scatter", "noise", "shape"):
        there = np.array([getattr(one, name) for one in drawn])
        assert ks_2samp(there, getattr(here, name)).pvalue > 1e-3


def test_the_law_of_a_curve_is_recognised_and_forecast():
    one, rng = fleet(LAWS[3], 2, 0, 1), np.random.default_rng(5)
    values = one.new[0].readings
    samples = [
        sample(law, [unit_evidence(law, others, False, rng) for others in one.others], rng)
        for law in LAWS[2:4]
    ]
    weighed = with_new_unit(samples, values, rng)
    chances = law_chances(weighed)
    assert chances.sum() == pytest.approx(1.0)
    assert chances[1] > 0.9
    probability = mean_forecast(weighed, values, rng)
    assert np.all(np.diff(probability) >= -1e-9)
    assert probability[0] < 0.01


def test_one_population_alone_is_forecast_as_by_the_oracle():
    rng = np.random.default_rng(6)
    populations = populations_at(LAWS[4], NOISY[None])
    values = fleet(LAWS[4], 0, 0, 1).new[0].readings
    found = mean_forecast([Sample(populations, np.zeros(1))], values, rng)
    expected = oracle(populations[0], values, GRID, rng).probability
    np.testing.assert_allclose(found, expected, atol=0.02)
