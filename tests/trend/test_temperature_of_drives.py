"""Drives whose friction follows the temperature: what is known of their wear in spite of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.stats import binom

from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.forecast.scores import sample_crps
from hdprog.inference.information import Linearised
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.results import TrendSummary
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.fitting import fit_trend
from hdprog.trend.joint_refit import Effort
from hdprog.trend.kalman_filter import at_reference, per_step_of_warmth
from hdprog.trend.smoother import draw, simulate
from hdprog.trend.state_space import HYPERPARAMETERS, Hyperparameters, Steps, Timeline
from hdprog.trend.summary import summarise
from hdprog.trend.temperature import SeenTests
from hdprog.trend.temperature_effect import temperature_effect, warmth_added
from hdprog.trend.trend import Trend
from hdprog.trend.wear_clock import ServiceClock
from hdprog.trend.wear_coordinates import StatePrior, from_loop, slope, to_loop
from hdprog.trend.wear_prior import read_wear_prior
from tests.hasty import HASTY
from tests.trend.cold_and_hot import CHANGE, COLD_AND_HOT, HOURS, MU, REACHED, drive
from tests.trend.stand_in import ALPHA, NEW, PRIOR, WEAR

WEAR_PRIOR = read_wear_prior()
STATE = StatePrior.of(PRIOR, WEAR_PRIOR)
OPERATION = Operation(ALPHA, 63.0, 63.0)
WIDTH = FigureRequest("hysteresis_width_arcmin")
READ = 0.004  # error of a reading in each wear coordinate


@dataclass
class Reading:
    """All wear coordinates of a test, read with a Gaussian error."""

    service_hours: float
    wear: np.ndarray
    temperature_C: float | None
    event: str | None = None
    load_hours: float | None = None
    exact: None = None

    @property
    def posterior(self) -> np.ndarray:
        return to_loop(self.wear)[None]

    def linearise(self, coordinates: np.ndarray) -> Linearised:
        at = from_loop(coordinates)
        steep = 1.0 / slope(at) / READ
        precision, missed = np.diag(steep**2), (self.wear - at) / READ
        information = precision @ coordinates + steep * missed
        return Linearised(precision, information, -0.5 * float(missed @ missed))


def readings(
    course: np.ndarray, change: np.ndarray, scatter: np.ndarray, rng: np.random.Generator
) -> list[Reading]:
    """Read a course (tests, 8) of wear coordinates, changed by temperature, in other mountings."""
    met = course + np.outer((np.array(COLD_AND_HOT) - 25.0) / 10.0, change)
    met = met + scatter * rng.standard_normal(met.shape)
    read = met + READ * rng.standard_normal(met.shape)
    return [Reading(*each) for each in zip(HOURS, read, COLD_AND_HOT, strict=True)]


def ignoring(tests: Sequence[Reading]) -> list[Reading]:
    return [replace(test, temperature_C=None) for test in tests]


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """150 drives drawn from the prior, hyperparameters known; 0.1 % false alarms a number.

    The course is drawn without temperature, whose part is added by hand.
    """
    drives, draws, rng = 150, 400, np.random.default_rng(3)
    values = Hyperparameters.of(np.zeros((1, len(HYPERPARAMETERS))), WEAR_PRIOR)
    many = Hyperparameters.of(np.zeros((draws, len(HYPERPARAMETERS))), WEAR_PRIOR)
    size = values.scatter[0] * WEAR_PRIOR.scales
    held = np.zeros((2, 8))
    for _ in range(drives):
        change = WEAR_PRIOR.warmer_mean + WEAR_PRIOR.warmer_sd * rng.standard_normal(8)
        blank = [Reading(hours, STATE.mean, None) for hours in HOURS]
        timeline, _ = Timeline.of(blank, ServiceClock.of(blank), WEAR_PRIOR)
        course = simulate(Steps.of(timeline, values, STATE, WEAR_PRIOR), rng).states[0]
        tests = readings(course, change, size, rng)
        clock = ServiceClock.of(tests)
        timeline, _ = Timeline.of(tests, clock, WEAR_PRIOR)
        steps = Steps.of(timeline, many, STATE, WEAR_PRIOR)
        loops = [Linearised(np.eye(8) / READ**2, test.wear / READ**2, 0.0) for test in tests]
        seen = SeenTests.of(loops, tests, WEAR_PRIOR).observations
        behind = draw(steps, seen, many.scatter, rng)
        last = at_reference(steps, behind.states[:, -1], behind.carried, HOURS.size - 1)
        for number, (found, truth) in enumerate(
            [(last, course[-1]), (per_step_of_warmth(steps, behind.carried), change)]
        ):
            low, high = np.quantile(found, [0.05, 0.95], axis=0)
            held[number] += (low < truth) & (truth < high)
    # Quantiles of 400 draws cost a few thousandths of the 90 %.
    low, high = binom.ppf([0.0005, 0.9995], drives, 0.895)
    assert np.all((held >= low) & (held <= high)), held


@pytest.fixture(scope="module")
def scores() -> np.ndarray:
    """CRPS of friction at the tests, (drives, tests, 2): temperature told, and not."""
    found = np.empty((2, HOURS.size, 2))
    for number in range(len(found)):
        rng = np.random.default_rng(20 + number)
        course = from_loop(NEW + WEAR * (HOURS[:, None] / 4000.0) ** 0.8)
        change = np.where(np.arange(8) == MU, [-0.12, 0.06][number], 0.0)
        tests = readings(course, change, 0.01 * np.ones(8), rng)
        for told, evidence in enumerate([tests, ignoring(tests)]):
            trend = fit_trend(evidence, PRIOR, WEAR_PRIOR, np.random.default_rng(1), quick=True)
            paths = trend.wandering_paths(HOURS, np.random.default_rng(2), 500)
            for test, state in enumerate(course):
                found[number, test, told] = sample_crps(paths.states[:, test, MU], state[MU])
    return found


def test_friction_is_known_better_than_without_temperature(scores: np.ndarray) -> None:
    """Over whole fits, which may take temperature for scatter where it is not told."""
    told, untold = scores.mean(axis=1).T
    assert np.all(told < untold)
    assert told.sum() < 0.75 * untold.sum()


# Real loops through fit and trend.

HOT = 3  # a hot test


def fitted(temperatures: Sequence[float | None], effort: Effort | None = None) -> Trend:
    tests, rng = drive(temperatures), np.random.default_rng(5)
    return fit_trend(tests, PRIOR, WEAR_PRIOR, rng, quick=True, joint_effort=effort)


@pytest.fixture(scope="module")
def trend() -> Trend:
    return fitted(COLD_AND_HOT)


@pytest.fixture(scope="module")
def summary(trend: Trend) -> TrendSummary:
    return _summary(trend)


def _summary(trend: Trend) -> TrendSummary:
    limits = (Limit(WIDTH.quantity, 0.2, "below"),)
    drive = Drive(limits=limits, forecast=ForecastSettings(6000.0))
    return summarise(trend, drive, OPERATION, np.random.default_rng(6))


def width(coordinates: np.ndarray) -> np.ndarray:
    return figure_paths(WIDTH, coordinates, PRIOR, OPERATION)


def test_the_course_at_the_reference_is_covered(trend: Trend) -> None:
    """Six widths inside their central 99.8 %: one false alarm in 80."""
    paths = width(trend.paths(HOURS, np.random.default_rng(7), 2000))
    low, high = np.quantile(paths, [0.001, 0.999], axis=0)
    truth = width(NEW + WEAR * REACHED[:, None])
    assert np.all((low < truth) & (truth < high))
    assert np.all(paths.std(axis=0) < 0.035 * truth)


def test_what_temperature_changes_is_told(summary: TrendSummary) -> None:
    """The true change inside its central 90 %; the interval far narrower than the prior's."""
    found = summary.temperature
    assert found is not None
    assert found.reference_C == pytest.approx(25.0)
    assert found.unknown == 0
    worn = NEW + WEAR * REACHED[-1]
    cool, warm = width(np.stack([worn, worn + CHANGE * np.eye(8)[MU]]))
    levels = found.percent_per_10K[WIDTH.key]
    assert levels[0.05] < 100.0 * (warm / cool - 1.0) < levels[0.95]
    assert levels[0.95] - levels[0.05] < 6.0


def test_tests_are_compared_with_the_trend_as_warm_as_it_is(
    trend: Trend, summary: TrendSummary
) -> None:
    """At its own temperature where a test is checked, at the reference where it is drawn."""
    assert not summary.not_reproduced
    measured = width(trend.measured(np.random.default_rng(8), 500)).mean(axis=0)
    own = width(np.stack([test.posterior for test in trend.tests], axis=1))
    assert np.all(np.abs(measured - own.mean(axis=0)) < 2 * own.std(axis=0))
    drawn = summary.figures[WIDTH.key]
    assert drawn.reference_C == pytest.approx(25.0)
    truth = width(NEW + WEAR * REACHED[:, None])
    off, drawn_off = own.mean(axis=0) / truth - 1.0, drawn.test_quantiles[2] / truth - 1.0
    assert np.sum(drawn_off**2) < 0.25 * np.sum(off**2)


def test_a_missing_temperature_does_not_mislead() -> None:
    """The hot test counts as one of any temperature that the others had."""
    told = [None if test == HOT else warm for test, warm in enumerate(COLD_AND_HOT)]
    doubtful = fitted(told, HASTY)
    at = HOURS[[HOT]]
    truth = float(width(NEW + WEAR * REACHED[HOT]))
    found = width(doubtful.paths(at, np.random.default_rng(9), 2000))[:, 0]
    low, high = np.quantile(found, [0.001, 0.999])
    assert low < truth < high
    summary = _summary(doubtful)
    assert summary.temperature is not None
    assert summary.temperature.unknown == 1
    assert not summary.not_reproduced


@pytest.mark.filterwarnings("error")
def test_a_width_of_nothing_changes_by_no_per_cent() -> None:
    """Where the teeth never slip, the width is exactly 0, however warm the drive is."""
    found = temperature_effect(
        fitted((20.0, 30.0), HASTY),
        [WIDTH],
        Operation(ALPHA, 2.0, 2.0),
        np.random.default_rng(1),
        50,
    )
    assert found is not None
    assert WIDTH.key not in found.percent_per_10K


def test_equal_temperatures_leave_every_number_as_it_is() -> None:
    """Bit for bit, through fit, paths, tests and summary."""
    none, same = fitted((None,) * 2, HASTY), fitted((21.0,) * 2, HASTY)
    assert np.array_equal(none.draws.chains, same.draws.chains)
    later = np.array([2500.0, 4000.0])
    first, second = (
        one.wandering_paths(later, np.random.default_rng(1), 50) for one in (none, same)
    )
    assert np.array_equal(first.states, second.states)
    assert not first.warmer.any()
    assert np.array_equal(
        none.measured(np.random.default_rng(2), 50), same.measured(np.random.default_rng(2), 50)
    )
    rng = np.random.default_rng(3)
    before = rng.bit_generator.state
    assert warmth_added(same, rng, 10) is None
    assert temperature_effect(same, [WIDTH], OPERATION, rng, 10) is None
    assert rng.bit_generator.state == before  # what is drawn after them stays as it was
    one, other = _summary(none), _summary(same)
    assert one.temperature is None
    assert other.temperature is None
    assert np.array_equal(
        one.figures[WIDTH.key].test_quantiles, other.figures[WIDTH.key].test_quantiles
    )


def test_a_replaced_drive_has_a_change_of_its_own() -> None:
    """Tests of one drive share their draws of it, those of two do not."""
    tests = drive(COLD_AND_HOT)
    tests[HOT] = replace(tests[HOT], event="replaced")
    rng = np.random.default_rng(5)
    trend = fit_trend(tests, PRIOR, WEAR_PRIOR, rng, quick=True, joint_effort=HASTY)
    added = warmth_added(trend, np.random.default_rng(1), 200)
    assert added is not None
    warmer = added[..., MU] / ((np.array(COLD_AND_HOT) - 25.0) / 10.0)
    spread = np.ptp(np.stack([warmer[:, :HOT], warmer[:, HOT:]], axis=1), axis=-1)
    assert spread.max() < 1e-12
    assert abs(np.corrcoef(warmer[:, 0], warmer[:, -1])[0, 1]) < 0.25  # 4e-4 by chance
