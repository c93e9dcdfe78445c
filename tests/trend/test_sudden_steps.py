"""Effects that came at once are told from those that grow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from hdprog.config import Drive, ForecastSettings
from hdprog.inference.information import Linearised
from hdprog.inference.likelihood import COUNT
from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.trend_words import off_course
from hdprog.results import SuddenEffect
from hdprog.trend.fitting import fit_trend
from hdprog.trend.loop_evidence import FittedLoop
from hdprog.trend.sudden_steps import came_at_once, clear_step, sudden_steps
from hdprog.trend.summary import summarise
from hdprog.trend.trend import Trend
from hdprog.trend.wear_clock import hours_by_load
from hdprog.trend.wear_prior import SuddenStep, read_wear_prior
from tests.trend.friction_beside import ALPHA, OPERATION, WIDEST, evidence, followed_by, likelihood
from tests.trend.friction_beside import PRIOR as OF_LOOPS

PRIOR = read_wear_prior()
COUNTS = (4, 5, 6, 8, 12)
SCATTERS = (0.05, 0.10)  # from test to test, of the amplitude
ERRORS = (0.02, 0.05)  # of a test by itself, of the largest amplitude
Course = Callable[[FloatArray], FloatArray]
GROWING: dict[str, Course] = {
    "line": lambda x: x,
    "line from a third": lambda x: 0.3 + 0.7 * x,
    "root": lambda x: np.sqrt(x),
    "square": lambda x: x**2,
    "cube": lambda x: x**3,
    "speeding up": lambda x: np.expm1(4 * x) / np.expm1(4.0),
    "levelling off": lambda x: np.expm1(-x / 0.3) / np.expm1(-1 / 0.3),
    "soon level": lambda x: np.expm1(-x / 0.1) / np.expm1(-1 / 0.1),
}


def hours(count: int, number: int, rng: np.random.Generator) -> FloatArray:
    """Service hours from 0 to 1000, evenly for every second drive."""
    gaps = np.ones(count - 1) if number % 2 else rng.gamma(2.5, size=count - 1)
    return np.asarray(1000 * np.concatenate([[0.0], np.cumsum(gaps) / gaps.sum()]))


def called(age: FloatArray, true: FloatArray, number: int, rng: np.random.Generator) -> int | None:
    """Step that the tests of one drawn drive show."""
    scatter, error = SCATTERS[number % 4 // 2], ERRORS[number % 8 // 4]
    noise = rng.standard_normal((2, age.size))
    seen = true * np.exp(scatter * noise[0]) + error * noise[1]
    seen /= np.abs(seen).max()
    return clear_step(age, seen, np.full(age.size, error), np.zeros(age.size, bool), PRIOR)


def false_alarms(course: Course, drives: int, rng: np.random.Generator) -> int:
    """How many of so many growing drives, of every count of tests, are said to step."""
    found = 0
    for count in COUNTS:
        for number in range(drives):
            age = hours(count, number, rng)
            found += called(age, course(age / 1000), number, rng) is not None
    return found


@pytest.mark.parametrize("name", GROWING)
def test_what_grows_is_not_said_to_step(name: str) -> None:
    """None of 200 drives: were one in 100 called, the test would fail in 87 % of its seeds."""
    assert false_alarms(GROWING[name], 40, np.random.default_rng(len(name))) == 0


def test_a_knee_is_hardly_ever_said_to_step() -> None:
    """Nothing up to a knee, a line from there: at most two of 200 drives.

    Off line 2 of 1000 were called; with that rate the test fails in 0.8 % of its seeds.
    """
    rng = np.random.default_rng(3)

    def knee(x: FloatArray) -> FloatArray:
        return np.asarray(np.maximum(x - rng.uniform(0.2, 0.7), 0.0))

    assert false_alarms(knee, 40, rng) <= 2


@pytest.mark.parametrize(("count", "fewest"), [(4, 0.25), (5, 0.6), (6, 0.65), (8, 0.8), (12, 0.9)])
def test_what_comes_at_once_is_called_and_placed(count: int, fewest: float) -> None:
    """Of 60 drives with two tests or more on either side; never at another place.

    Off line 200 drives of each count gave 0.44, 0.78, 0.81, 0.93 and 0.99: the bounds lie three
    standard errors below.
    """
    rng = np.random.default_rng(count)
    places = []
    for number in range(60):
        age, after = hours(count, number, rng), int(rng.integers(2, count - 1))
        found = called(age, (np.arange(count) >= after).astype(float), number, rng)
        places.append(None if found is None else found - after)
    assert set(places) <= {None, 0}
    assert np.mean([place == 0 for place in places]) >= fewest


AGE = np.linspace(0.0, 1000.0, 8)
CAME = (AGE > 500).astype(float)
SURE, NONE = np.full(8, 0.03), np.zeros(8, dtype=bool)


def test_a_clear_step_is_found_also_above_what_was_there_and_on_top_of_growth() -> None:
    assert clear_step(AGE, CAME, SURE, NONE, PRIOR) == 4
    assert clear_step(AGE, 0.2 + 0.8 * CAME, SURE, NONE, PRIOR) == 4
    assert clear_step(AGE, 0.2 * AGE / 1000 + 0.8 * CAME, SURE, NONE, PRIOR) == 4


@pytest.mark.parametrize("after", [1, 7])
def test_one_test_on_either_side_does_not_tell(after: int) -> None:
    """The last alone may lie behind a knee, the first before what soon levels off."""
    came = (np.arange(8) >= after).astype(float)
    assert clear_step(AGE, came, SURE, NONE, PRIOR) is None


def test_tests_that_do_not_tell_do_not_say_that_the_effect_was_absent() -> None:
    """Not found before, though half of it, or all, may have been there."""
    unsure = np.where(CAME > 0, 0.03, 0.6)
    assert clear_step(AGE, CAME, unsure, NONE, PRIOR) is None


def test_a_step_that_is_declared_is_not_called_again() -> None:
    declared = np.arange(8) == 4
    assert clear_step(AGE, CAME, SURE, declared, PRIOR) is None


def test_a_declared_step_does_not_hide_another() -> None:
    at = np.arange(12)
    twice = ((at >= 4) + (at >= 8).astype(float)) / 2
    age, sure = 100.0 * at, np.full(12, 0.03)
    assert clear_step(age, twice, sure, at == 4, PRIOR) == 8


def test_growth_in_a_stretch_of_heavy_load_is_no_step() -> None:
    """Three times the torque wears 27 times as fast; by the hours alone it looks like a step."""
    age = np.linspace(0.0, 3500.0, 8)
    torque = [None, 20.0, 22.0, 20.0, 60.0, 25.0, 20.0, 22.0]
    by_load = np.array(hours_by_load(age.tolist(), torque, [None] * 8))
    grown = by_load / by_load[-1]
    assert clear_step(age, grown, SURE, NONE, PRIOR) == 4
    assert clear_step(age, grown, SURE, NONE, PRIOR, by_load) is None
    elsewhere = 0.1 * grown + 0.9 * (age > 2500.0)
    assert clear_step(age, elsewhere, SURE, NONE, PRIOR, by_load) == 6


def test_tests_at_one_hour_have_nothing_between_them() -> None:
    age = AGE.copy()
    age[4] = age[3]
    assert clear_step(age, CAME, SURE, NONE, PRIOR) != 4
    assert clear_step(np.zeros(8), CAME, SURE, NONE, PRIOR) is None


@dataclass(frozen=True)
class Told:
    """A test that tells an amplitude to three per cent, and of the drive model nothing."""

    service_hours: float
    amplitude: float
    event: str | None = None
    load_hours = temperature_C = exact = None

    @property
    def posterior(self) -> FloatArray:
        return np.append(OF_LOOPS.mean, self.amplitude)[None]

    def linearise(self, _coordinates: FloatArray) -> Linearised:
        precision = np.diag([0.0] * COUNT + [0.03**-2])
        return Linearised(precision, precision[-1] * self.amplitude, 0.0)


def test_new_grease_may_change_friction_beside_the_model_and_nothing_else_beside_it() -> None:
    """It is declared, so no step that comes of itself is told there."""
    friction, play = PRIOR.following(1, (True,)), PRIOR.following(1, (False,))
    assert friction.event_variance("regreased")[-1] == PRIOR.effect.initial_sd**2
    assert play.event_variance("regreased")[-1] == friction.event_variance(None)[-1] == 0.0
    assert friction.event_variance("reassembled")[-1] > 0.0
    assert friction.identity == PRIOR.identity
    tests = [
        Told(100.0 * at, 1.0 if at < 4 else 0.3, "regreased" if at == 4 else None)
        for at in range(8)
    ]
    assert sudden_steps(tests, OF_LOOPS, friction) == ()
    assert sudden_steps(tests, OF_LOOPS, play) == (SuddenStep(4, 0),)


def steps_told(amplitudes: Sequence[float], replaced: int) -> tuple[SuddenStep, ...]:
    """Steps of a drive that was replaced just before a test."""
    tests = [
        Told(100.0 * at, size, "replaced" if at == replaced else None)
        for at, size in enumerate(amplitudes)
    ]
    return sudden_steps(tests, OF_LOOPS, PRIOR.following(1))


def test_each_drive_between_replacements_has_steps_of_its_own() -> None:
    assert steps_told([0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 1, 1], replaced=6) == (
        SuddenStep(test=3, amplitude=0),
        SuddenStep(test=10, amplitude=0),
    )
    assert steps_told([0, 0, 0, 0, 0, 1, 1, 1, 1, 1], replaced=5) == ()


def test_a_sudden_step_is_part_of_the_states_variance_before_its_test() -> None:
    followed = PRIOR.following(2)
    stepping = followed.stepping([SuddenStep(test=3, amplitude=1)])
    added = stepping.step_variance(3, None) - followed.step_variance(3, None)
    np.testing.assert_allclose(added, [0.0] * 9 + [PRIOR.effect.initial_sd**2])
    assert not stepping.step_variance(2, None).any()
    both = stepping.step_variance(3, "reassembled")
    np.testing.assert_allclose(both - added, PRIOR.following(2).event_variance("reassembled"))
    assert stepping.identity == PRIOR.identity


@pytest.fixture(scope="module")
def stepped() -> Trend:
    """Three tests without friction beside the drive model and four with it, as it came."""
    followed = followed_by(likelihood(0.0, 1))
    rng = np.random.default_rng(8)
    tests = [
        evidence(WIDEST * (number >= 3), 200.0 * number, number, followed) for number in range(7)
    ]
    return fit_trend(tests, OF_LOOPS, PRIOR, rng, quick=True, alpha=ALPHA, followed=followed)


def test_the_trend_takes_it_for_a_step_that_lasts(stepped: Trend) -> None:
    """Absent before, whole after, and no larger for the wear to come: 90 % intervals hold that."""
    assert stepped.wear_prior.sudden == (SuddenStep(test=3, amplitude=0),)
    assert stepped.breaks
    hours = np.array([200.0, 390.0, 600.0, 1200.0, 2000.0])
    amplitude = stepped.paths(hours, np.random.default_rng(1), 600)[..., COUNT]
    low, middle, high = np.quantile(amplitude, (0.05, 0.5, 0.95), axis=0)
    true = np.array([0.0, 0.0, 1.0, 1.0, 1.0])
    assert np.all((low < true) & (true < high))
    np.testing.assert_allclose(middle, true, atol=0.15)
    assert (high - low)[:4].max() < 0.4


def test_the_summary_names_the_effect_and_its_course_breaks_at_the_test(stepped: Trend) -> None:
    drive = Drive(forecast=ForecastSettings(2000.0))
    found = summarise(stepped, drive, OPERATION, np.random.default_rng(2))
    assert found.sudden == (SuddenEffect("coulomb_friction", 3, True),)
    width = found.figures["hysteresis_width_arcmin"]
    course = width.quantiles[2][np.searchsorted(width.hours, [400.0, 600.0])]
    whole = ARCMIN_PER_RAD * WIDEST
    assert course[1] - course[0] == pytest.approx(whole, rel=0.2)
    assert off_course(width) == []


def test_what_is_not_followed_does_not_step() -> None:
    alone = FittedLoop(0.0, None, None, None, np.zeros((2, COUNT)), None, None, 1.0, None)
    assert came_at_once([alone], OF_LOOPS, PRIOR) == frozenset()
