"""Forecasts from earlier tests, scored by what came later."""

from __future__ import annotations

import dataclasses
import math
from unittest import mock
from unittest.mock import ANY

import numpy as np
import pytest

from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.data.truth_file import Truth
from hdprog.forecast import backtest
from hdprog.forecast.backtest import CrossingScore, OriginScores, score_crossing, score_origin
from hdprog.forecast.backtest_pool import (
    DriveScores,
    crossing_courses,
    crossing_coverage,
    distinct_crossings,
    figure_skills,
    known_lateness,
    lateness,
)
from hdprog.forecast.crossing import Crossing
from hdprog.forecast.limits import Margins
from hdprog.forecast.what_came import (
    SeenTest,
    first_passing,
    passed_between,
    seen_test,
    straight_line,
    until_intervention,
    what_came,
)
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.fitting import fit_trend
from hdprog.trend.wear_prior import read_wear_prior
from tests.hasty import HASTY
from tests.trend import cold_and_hot
from tests.trend.stand_in import ALPHA, NEW, PRIOR, WEAR, wearing_drive

OPERATION = Operation(ALPHA, 63.0, 63.0)
LOST = Limit("lost_motion_arcmin", 2.0, "above")
SECANT = Limit("secant_stiffness_Nm_per_rad", 12_000.0, "below", 14.0)
# F rises evenly from 0 at 100 h to 0.8 at 900 h.
HOURS = np.linspace(100.0, 900.0, 81)
EVEN = Crossing(HOURS, (HOURS - 100.0) / 1000.0, already=False, paths=1000)


def a_test(name: str, hours: float, lost_motion: float, event: str | None = None) -> SeenTest:
    return SeenTest(name, hours, event, {LOST.key: np.array([lost_motion])})


def score(crossed_at: float, seen_until: float = 900.0) -> CrossingScore:
    return score_crossing(LOST, EVEN, crossed_at, seen_until, False, 0.5, 900.0)


def test_lines_between_tests_tell_the_crossing() -> None:
    hours = [100.0, 200.0, 400.0]
    assert first_passing(hours, [1.0, 1.5, 2.5], LOST) == pytest.approx(300.0)
    assert first_passing(hours, [1.0, 1.5, 1.9], LOST) == math.inf
    assert first_passing(hours, [2.0, 1.0, 1.0], LOST) == 100.0
    # Past the limit for one test only: the first passing counts, whatever comes then.
    assert first_passing(hours, [1.0, 3.0, 1.0], LOST) == pytest.approx(150.0)
    assert first_passing(hours, [20e3, 16e3, 8e3], SECANT) == pytest.approx(300.0)


def test_tests_tell_between_which_of_them_a_limit_was_passed() -> None:
    origin, later = a_test("a", 100, 1.0), [a_test("b", 200, 1.5), a_test("c", 400, 2.5)]
    assert passed_between(LOST, origin, later) == (200, 400)
    assert passed_between(LOST, origin, later[:1]) is None
    assert passed_between(LOST, a_test("a", 100, 3.0), later) is None


def test_the_typical_forecast_is_between_those_that_came_early_and_late() -> None:
    """By the straight line two are late; the tests tell that of one alone."""
    tests = {550.0: (520.0, 700.0), 620.0: (610.0, 700.0), 400.0: (350.0, 450.0)}
    seen = [dataclasses.replace(score(at), passed_between=ends) for at, ends in tests.items()]
    origins = tuple(
        OriginScores(f"t{n}", 100.0, 0.0, 3, True, (one,), (), ()) for n, one in enumerate(seen)
    )
    found = known_lateness([DriveScores("d", "d", 5, 900.0, (), origins)])
    assert found is not None
    assert found.within_tests
    assert found.share == pytest.approx(50.0 / 450.0)


def test_the_straight_line() -> None:
    assert straight_line([0.0, 100.0], [1.0, 2.0], 300.0) == pytest.approx(4.0)
    assert straight_line([50.0], [1.5], 300.0) == 1.5


def test_what_is_done_to_the_drive_later_ends_what_is_scored() -> None:
    tests = [a_test("b", 200, 1.0), a_test("c", 300, 9.0, "regreased"), a_test("d", 400, 9.0)]
    assert [test.test_id for test in until_intervention(tests)] == ["b"]


def test_the_truth_wins_where_it_is_known() -> None:
    origin, later = a_test("a", 100, 1.0), [a_test("b", 300, 3.0)]
    assert what_came(LOST, origin, later, None, 900.0) == (300.0, 200.0, False)
    truth = Truth({LOST: 700.0}, 800.0)
    assert what_came(LOST, origin, later, truth, 900.0) == (800.0, 700.0, True)
    # A crossing behind the horizon was not seen.
    assert what_came(LOST, origin, later, truth, 600.0) == (600.0, math.inf, True)
    assert what_came(LOST, origin, later, Truth({SECANT: 700.0}, 800.0), 900.0)[2] is False


def test_scores_of_a_crossing_by_hand() -> None:
    found = score(400.0)
    assert found.quantiles[0.5] == pytest.approx(600.0)
    assert found.quantiles[0.95] is None  # past the horizon
    assert found.held == {0.5: True, 0.9: True}
    assert found.own_probability[0.5] == pytest.approx(0.5)
    assert found.own_probability[0.9] == pytest.approx(0.95)  # its late end is open
    assert found.transform == pytest.approx(0.3)
    assert found.log_score == pytest.approx(math.log(1000.0))
    # ∫ F² up to 400 h and ∫ (1 − F)² from there, F in thousandths of hours.
    assert found.crps_hours == pytest.approx(1000 * (0.3**3 + 0.7**3 - 0.2**3) / 3)
    assert found.late_hours == pytest.approx(200.0)
    assert found.accuracy == pytest.approx(1 - 200 / 300)
    assert found.within_alpha == pytest.approx(0.12)  # from 340 to 460 h


def test_a_limit_not_passed_is_scored_up_to_the_last_test_only() -> None:
    found = score(math.inf, seen_until=500.0)
    assert not found.crossing_seen
    assert found.crossed_by_then == pytest.approx(0.4)
    assert found.crps_hours == pytest.approx(1000 * 0.4**3 / 3)
    assert found.log_score == pytest.approx(-math.log(0.6))
    assert found.transform == pytest.approx(0.7)
    assert found.held == {0.5: True, 0.9: True}
    assert found.own_probability[0.5] == pytest.approx(0.75)
    assert (found.late_hours, found.accuracy, found.within_alpha) == (None, None, None)
    assert found.quantiles[0.75] == pytest.approx(850.0)  # as forecast, not as cut


def drive_of(*scores: CrossingScore) -> DriveScores:
    origins = [
        OriginScores(f"t{n}", 100.0, 0.0, 3, True, (one,), (), ()) for n, one in enumerate(scores)
    ]
    return DriveScores("d", "d", len(scores) + 1, 900.0, (), tuple(origins))


def once(early: float, late: float) -> CrossingScore:
    """Score of a crossing at 400 h that is forecast between two hours."""
    hours = np.array([100.0, early, late, 900.0])
    forecast = Crossing(hours, np.array([0.0, 0.0, 1.0, 1.0]), already=False, paths=1000)
    return score_crossing(LOST, forecast, 400.0, 900.0, False, 0.5, 900.0)


def test_pooled_scores() -> None:
    drive = drive_of(score(400.0), score(300.0), score(110.0))
    found = crossing_coverage(drive.crossings, 0.9)
    assert found is not None
    assert (found.held, found.count) == (2, 3)
    assert found.expected == pytest.approx(0.95)
    assert crossing_coverage([], 0.9) is None
    # Errors of 600 h over remaining lives of 300, 200 and 10 h: 200/300, 300/200, 490/10.
    assert lateness([drive]) == pytest.approx(1.5)
    assert lateness([drive], known=4) is None
    drive = drive_of(once(500.0, 700.0), once(300.0, 700.0), once(350.0, 420.0))
    assert distinct_crossings([drive, drive]) == 2
    (course,) = crossing_courses([drive])
    assert course.prognostic_horizon == 300.0
    assert course.accuracy == pytest.approx(np.mean([1 / 3, 2 / 3, 1 - 15 / 300]))


def test_a_limit_that_is_crossed_again_is_another_crossing() -> None:
    """By a drive that replaced another: neither has the other's forecasts."""
    drive = drive_of(score(300.0), score(300.0), score(700.0), score(math.inf, 800.0))
    courses = crossing_courses([drive])
    assert [course.crossed_at for course in courses] == [300.0, 700.0]
    assert [len(course.scores) for course in courses] == [2, 1]
    assert distinct_crossings([drive]) == 1


def test_the_life_of_a_drive_that_replaced_another_is_its_own() -> None:
    drive = drive_of(score(300.0), score(700.0))
    new = dataclasses.replace(drive.origins[1], service_hours=500.0, new_at_hours=450.0)
    drive = dataclasses.replace(drive, origins=(drive.origins[0], new))
    assert [course.first_hours for course in crossing_courses([drive])] == [0.0, 450.0]
    assert distinct_crossings([drive]) == 2


@pytest.fixture(scope="module")
def origin() -> OriginScores:
    """From the fourth of seven tests; the sixth stands out by a mounting of its own."""
    rng = np.random.default_rng(5)
    hours = np.array([0, 500, 1000, 1500, 2000, 2500, 3000], dtype=float)
    tests = wearing_drive(rng, (hours / 4000.0) ** 0.9, hours)
    drive = Drive(rated_torque=63.0, limits=(SECANT, LOST), forecast=ForecastSettings(10_000.0))
    seen = [
        seen_test(f"t{n}", test, drive.limits, PRIOR, OPERATION) for n, test in enumerate(tests, 1)
    ]
    truth = Truth({SECANT: 4000.0}, 10_000.0)
    seed = np.random.SeedSequence(3)
    wear = read_wear_prior()
    return score_origin(tests[:4], seen, drive, PRIOR, wear, OPERATION, truth, seed, quick=True)


def test_an_origin_forecasts_limits_and_later_tests(origin: OriginScores) -> None:
    assert (origin.test_id, origin.service_hours, origin.known) == ("t4", 1500.0, 4)
    by_limit = {found.limit: found for found in origin.crossings}
    secant, lost = by_limit[SECANT], by_limit[LOST]
    assert (secant.crossed_at, secant.seen_until, secant.from_truth) == (4000.0, 10_000.0, True)
    assert not lost.from_truth
    assert lost.seen_until == 3000.0
    # The wear is the model's own; 90 % intervals miss in one seed of ten.
    assert secant.held[0.9]
    median = secant.quantiles[0.5]
    assert median is not None
    assert 2000.0 < median < 10_000.0
    for found in origin.figures:
        assert found.ahead == {2000.0: 1, 2500.0: 2, 3000.0: 3}[found.service_hours]
        assert found.quantiles[0.05] < found.quantiles[0.5] < found.quantiles[0.95]
        assert found.crps > 0
        assert 0 <= found.transform <= 1
    assert len(origin.figures) == 6
    # All six outside: 1 in 10 to the number of independent ones, three at least by the mountings.
    assert sum(found.held[0.9] for found in origin.figures) >= 3
    assert {skill.key for skill in figure_skills(origin.figures)} == {SECANT.key, LOST.key}


def test_spread_of_the_mounting_and_of_the_test_is_in_the_prediction(origin: OriginScores) -> None:
    """Remounting scatters the stiffness by about 1 %; the state alone is known far better."""
    nearest = next(found for found in origin.figures if found.key == SECANT.key)
    width = nearest.quantiles[0.95] - nearest.quantiles[0.05]
    assert width > 0.01 * nearest.measured


def test_a_later_test_is_predicted_as_warm_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a drive whose friction falls by a tenth in 10 K; the last test was hot."""
    width = Limit("hysteresis_width_arcmin", 0.2, "below")
    drive = Drive(limits=(width,), forecast=ForecastSettings(10_000.0))
    tests = cold_and_hot.drive(cold_and_hot.COLD_AND_HOT)
    seen = [seen_test(f"t{n}", one, [width], PRIOR, OPERATION) for n, one in enumerate(tests)]
    assert seen[-1].temperature_C == 35.0
    wear = read_wear_prior()
    rng = np.random.default_rng(3)
    trend = fit_trend(tests[:-1], PRIOR, wear, rng, quick=True, joint_effort=HASTY)
    monkeypatch.setattr(backtest, "fit_trend", lambda *_, **__: trend)
    predicted = []
    # What mounting adds to the last test speaks for one or the other: its width is the true one.
    friction = cold_and_hot.CHANGE * (35.0 - 25.0) / 10.0 * np.eye(8)[cold_and_hot.MU]
    state = NEW + WEAR * cold_and_hot.REACHED[-1] + friction
    true = figure_paths(FigureRequest.of(width), state[None, None], PRIOR, OPERATION)[0]
    for warm in (35.0, 15.0, None):
        last = dataclasses.replace(seen[-1], temperature_C=warm, figures={width.key: true})
        told = [*seen[:-1], last]
        seed = np.random.SeedSequence(3)
        scored = score_origin(tests[:-1], told, drive, PRIOR, wear, OPERATION, None, seed)
        predicted.append(scored.figures[0])
    hot, cold, unknown = predicted
    # The same forecast, told at other temperatures: 20 K are a fifth of the width.
    assert hot.quantiles[0.5] == pytest.approx(0.82 * cold.quantiles[0.5], rel=0.05)
    assert hot.crps < 0.8 * min(cold.crps, unknown.crps)
    spread = [one.quantiles[0.95] - one.quantiles[0.05] for one in predicted]
    assert spread[2] > max(spread[:2])


def stand_in_trend(monkeypatch: pytest.MonkeyPatch, now: float) -> list[list[str]]:
    """Put a trend in the place of a fitted one; gives the tests that figures are scored by."""
    trend, earlier = mock.Mock(now_hours=now, prior=PRIOR, converged=True), []

    def figures(_trend: object, _paths: object, known: list[SeenTest], *_: object) -> tuple[()]:
        earlier.append([test.test_id for test in known])
        return ()

    monkeypatch.setattr(backtest, "fit_trend", lambda *_, **__: trend)
    monkeypatch.setattr(backtest, "_score_figures", figures)
    return earlier


def score_from(monkeypatch: pytest.MonkeyPatch, seen: list[SeenTest], known: int, truth: Truth):
    """Score a stand-in of a trend to the first tests; nothing is crossed before the horizon."""
    earlier = stand_in_trend(monkeypatch, seen[known - 1].service_hours)
    far = lambda *_: Margins(np.ones((10, 1)), np.zeros((10, 1)))  # noqa: E731
    monkeypatch.setattr(backtest, "margins", far)
    monkeypatch.setattr(backtest, "first_crossing", lambda *_, **__: EVEN)
    drive = Drive(rated_torque=63.0, limits=(LOST,), forecast=ForecastSettings(900.0))
    seed = np.random.SeedSequence(1)
    wear = read_wear_prior()
    found = score_origin([ANY] * known, seen, drive, PRIOR, wear, OPERATION, truth, seed)
    return found, earlier[0]


@pytest.mark.parametrize(
    ("event", "seen_until", "crossed_at"),
    [(None, 900.0, 700.0), ("regreased", 300.0, math.inf), ("replaced", 300.0, math.inf)],
)
def test_the_truth_behind_what_was_done_to_the_drive_is_not_what_was_forecast(
    monkeypatch: pytest.MonkeyPatch, event: str | None, seen_until: float, crossed_at: float
) -> None:
    seen = [a_test("a", 100, 1.0), a_test("b", 300, 1.2), a_test("c", 500, 0.5, event)]
    found, _ = score_from(monkeypatch, seen, 1, Truth({LOST: 700.0}, 5000.0))
    (one,) = found.crossings
    assert (one.seen_until, one.crossed_at) == (seen_until, crossed_at)
    found, _ = score_from(monkeypatch, seen, 2, Truth({LOST: 700.0}, 5000.0))
    assert len(found.crossings) == (event is None)


def test_the_straight_line_is_not_drawn_through_the_drive_that_was_replaced(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen = [a_test("a", 100, 1.8), a_test("b", 200, 0.5, "replaced"), a_test("c", 300, 0.6)]
    found, earlier = score_from(monkeypatch, [*seen, a_test("d", 400, 0.7)], 3, Truth({}, 900.0))
    assert earlier == ["b", "c"]
    assert (found.new_at_hours, found.known) == (200.0, 2)


def test_forecasts_near_a_limit_are_scored_as_those_of_drives_that_are_not_past_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Drives whose room to the limit is known to ± 0.15 and shrinks evenly; those past it go.

    Transforms are uniform: 4.5 standard errors of their mean, a false alarm in 10 000 seeds.
    """
    drive = Drive(rated_torque=63.0, limits=(LOST,), forecast=ForecastSettings(4000.0))
    rng = np.random.default_rng(1)
    stand_in_trend(monkeypatch, 0.0)
    wear, hours, transforms = read_wear_prior(), backtest.forecast_hours(0.0, 4000.0), []
    for number, room in enumerate(rng.uniform(0.0, 2.0, 2000)):
        seen = room + 0.15 * rng.standard_normal()
        if seen > 0.3:
            continue
        margin = seen + 0.15 * rng.standard_normal((200, 1)) - 1e-3 * hours
        found = Margins(margin, np.zeros_like(margin))
        monkeypatch.setattr(backtest, "margins", lambda *_, found=found: found)
        came = Truth({LOST: 1e3 * room}, 4000.0)
        known, seed = [a_test("a", 0.0, 2.0 - seen)], np.random.SeedSequence(number)
        scored = score_origin([ANY], known, drive, PRIOR, wear, OPERATION, came, seed)
        transforms += [one.transform for one in scored.crossings]
    assert len(transforms) > 200
    assert np.mean(transforms) == pytest.approx(0.5, abs=4.5 / np.sqrt(12 * len(transforms)))


def test_a_crossing_behind_the_origin_is_not_forecast() -> None:
    early = dataclasses.replace(LOST, threshold=0.9)
    tests = [a_test("a", 100, 1.0), a_test("b", 300, 3.0)]
    end, crossed_at, _ = what_came(early, tests[0], tests[1:], None, 900.0)
    assert (end, crossed_at) == (300.0, 100.0)
