"""The words of the verdict in every situation, whole sentences at a time."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hdprog.config import Limit
from hdprog.reporting import outlook
from hdprog.reporting.figures.service_life import life_picture, trend_pictures
from hdprog.reporting.fleet_words import fleet_entry
from hdprog.reporting.present import probability_bounds
from hdprog.reporting.sections.facts import facts
from hdprog.reporting.sections.remaining_life import limits_table
from hdprog.reporting.style import house_style
from hdprog.reporting.summary import summary_json
from hdprog.reporting.verdict import Verdict, verdict
from hdprog.results import LEVELS, DriveResult, Forecast, NotReproduced, Sensitivity
from tests.reporting import drives
from tests.reporting.page import spaced


def words(result: DriveResult) -> tuple[Verdict, list[str]]:
    said = verdict(result)
    return said, [spaced(sentence) for sentence in said.sentences]


def with_quantiles(
    result: DriveResult, early: float, late: float | None, inspect: float | None, **changes: object
) -> DriveResult:
    """Result whose only forecast has these service hours."""
    first = result.forecasts[0]
    remaining = {
        0.05: early - first.now_hours,
        0.25: early - first.now_hours + 100.0,
        0.50: early - first.now_hours + 400.0,
        0.75: None if late is None else late - first.now_hours - 100.0,
        0.95: None if late is None else late - first.now_hours,
    }
    changed = replace(
        first,
        remaining_hours=remaining,
        inspect_before_hours=inspect,
        **changes,  # type: ignore[arg-type]
    )
    return replace(result, forecasts=(changed,))


def test_a_wearing_drive_gets_an_interval_and_a_date() -> None:
    result = with_quantiles(
        drives.wearing(), 1460.0, 2280.0, 1310.0, probability_crossed_by_shutdown=0.12
    )
    said, sentences = words(result)
    assert (said.status, said.provisional, said.label) == ("plan", False, "Plan an inspection")
    assert sentences == [
        "Lost motion is forecast to pass 2 arcmin between 1 450 and 2 300 h (90 %); "
        "inspect before 1 300 h.",
        "If nothing is done, the risk by the next shutdown at 1 500 h is 12 %, above the accepted "
        "5 %: do not wait for it.",
        "Test again by 1 100 h.",
    ]


def test_a_date_that_is_near_beside_the_time_between_tests_is_tested_for_now() -> None:
    """Half-way to it would be hours after the last test, too few for wear to show."""
    result = drives.wearing()
    now = result.forecasts[0].now_hours
    tested = sorted(test.service_hours or 0.0 for test in result.tests)
    longest = max(late - early for early, late in pairwise(tested))
    near, far = (with_quantiles(result, now + wait, 2280.0, now + wait) for wait in (8.0, longest))
    assert words(near)[1][-1].startswith("Test again now, the joint mounted anew")
    assert words(far)[1][-1].startswith("Test again by ")
    tiles = {fact.label: fact for fact in facts(near)}
    assert tiles["Test again"].value == "now"
    assert "within 8" in tiles["Test again"].note


def test_a_limit_below_is_fallen_below() -> None:
    result = with_quantiles(drives.wearing(drives.SECANT), 1460.0, 2280.0, 1310.0)
    _, sentences = words(result)
    assert sentences[0].startswith(
        "Secant stiffness at 14 Nm is forecast to fall below 12 000 Nm/rad between 1 450 and "
    )


def test_a_late_quantile_past_the_horizon_gets_no_number() -> None:
    result = with_quantiles(
        drives.wearing(shutdown=None), 1460.0, None, 1310.0, probability_crossed_by_horizon=0.77
    )
    _, sentences = words(result)
    assert sentences[0] == (
        "Lost motion is forecast to pass 2 arcmin not before 1 400 h (95 %) and, with a "
        "probability of 23 %, later than 20 000 h; inspect before 1 300 h."
    )


def test_a_limit_that_a_large_accepted_risk_leaves_alone_is_in_sight() -> None:
    result = with_quantiles(
        drives.wearing(risk=0.3, count=2, samples=600),
        15_000.0,
        None,
        None,
        probability_crossed_by_horizon=0.2,
    )
    said, sentences = words(result)
    assert (said.status, said.label) == ("good", "Within the accepted risk")
    assert sentences[0].endswith("with a probability of 80 %, later than 20 000 h.")


def test_a_healthy_drive_is_left_alone() -> None:
    said, sentences = words(drives.healthy())
    assert (said.status, said.label) == ("good", "No limit in sight")
    assert sentences == [
        "Lost motion is not forecast to pass 2 arcmin before 20 000 h (probability more than "
        "99 %).",
        "If nothing is done, the risk by the next shutdown at 1 500 h is less than 1 %, within the "
        "accepted 5 %: it can wait.",
        "Test again by 1 040 h.",
    ]


def test_a_small_accepted_risk_asks_for_an_inspection_though_no_quantile_is_inside() -> None:
    result = drives.wearing(crossing=5000.0, never=0.97, risk=0.01, shutdown=None)
    said, sentences = words(result)
    assert said.status == "plan"
    assert sentences[0].startswith(
        "Lost motion is not forecast to pass 2 arcmin before 20 000 h (probability 97 %); inspect "
        "before "
    )


def test_a_limit_already_passed_comes_first() -> None:
    said, sentences = words(drives.past_limit())
    assert (said.status, said.label) == ("act", "Act now")
    assert sentences[0].startswith("Lost motion is past its limit: above 2 arcmin; it is 2.4")
    assert sentences[0].endswith("with a probability of more than 99 %.")
    assert sentences[1] == "Inspect now."
    assert not any("Test again" in sentence or "between" in sentence for sentence in sentences)


def test_a_limit_that_may_be_passed_is_not_said_to_be() -> None:
    """Even odds stood beside a median on the right side of the limit."""
    result = drives.past_limit()
    (passed,) = outlook.passed(result.forecasts)
    course = passed.crossing_probability.copy()
    course[:, 1] = 0.55
    doubtful = replace(passed, crossing_probability=course)
    each = tuple(doubtful if one is passed else one for one in result.forecasts)
    said, sentences = words(replace(result, forecasts=each))
    assert said.status == "act"
    assert sentences[0].startswith("Lost motion is more likely than not past its limit: above 2")
    assert sentences[0].endswith("past the limit with a probability of 55 %.")
    assert sentences[1] == "Inspect now."


def test_a_limit_passed_tests_ago_is_told_since_when() -> None:
    """Whether it was news of the last test or known for months is what a foreman asks first."""
    long_past = words(drives.wearing(drives.LOST_MOTION, crossing=400.0, spread=20.0))[1][0]
    assert long_past.endswith("99 %. Every test since t05 at 600 h shows it passed.")
    assert "shows it passed" not in words(drives.past_limit())[1][0]


def test_what_was_done_as_a_limit_was_passed_is_told() -> None:
    """New grease takes a width that stands for preload past its limit, without any wear."""
    result = drives.past_limit()

    def first_words(**events: str) -> str:
        tests = (replace(one, event=events.get(one.test_id)) for one in result.tests)
        return words(replace(result, tests=tuple(tests)))[1][0]

    told = first_words(t07="regreased")
    assert "99 %. Test t06, before the drive was regreased, had 1.8" in told
    assert told.endswith("what was done may have taken it past, not wear.")
    assert "may have taken" not in first_words(t06="regreased")
    assert "may have taken" not in first_words(t07="replaced")


def test_a_passed_limit_does_not_hide_the_next_one() -> None:
    passed = drives.past_limit()
    coming = drives.wearing(drives.SECANT)
    assert passed.trend is not None
    assert coming.trend is not None
    figures = {**passed.trend.figures, **coming.trend.figures}
    result = replace(
        passed,
        forecasts=(*passed.forecasts, *coming.forecasts),
        trend=replace(passed.trend, figures=figures),
    )
    _, sentences = words(result)
    assert sentences[1] == "Inspect now."
    assert sentences[2].startswith("Secant stiffness at 14 Nm is forecast to fall below")


def test_past_one_limit_the_soonest_of_the_others_is_told() -> None:
    passed, coming = drives.past_limit(), drives.wearing(drives.SECANT).forecasts[0]
    far = replace(
        coming, remaining_hours=dict.fromkeys(coming.remaining_hours), limit=drives.LOST_MOTION
    )
    _, sentences = words(replace(passed, forecasts=(*passed.forecasts, far, coming)))
    assert sentences[2].startswith("Secant stiffness at 14 Nm is forecast to fall below")


def test_a_risk_reached_today_asks_for_an_inspection_now() -> None:
    result = drives.wearing(crossing=1000.0, spread=120.0, shutdown=None)
    said, sentences = words(result)
    assert said.status == "act"
    assert "inspect now." in sentences[1]
    assert "the accepted risk is 5 %" in sentences[1]


@pytest.mark.parametrize(
    ("ahead", "words_now", "test_again"),
    [
        (1.7, "reaches the accepted 5 % within two hours: inspect now.", False),
        (2.3, "; inspect before", True),
        (400.0, "; inspect before", True),
    ],
)
def test_what_is_due_within_two_hours_is_due_now(
    ahead: float, words_now: str, test_again: bool
) -> None:
    result = drives.wearing()
    forecasts = tuple(
        replace(one, inspect_before_hours=one.now_hours + ahead) for one in result.forecasts
    )
    said, sentences = words(replace(result, forecasts=forecasts))
    assert words_now in " ".join(sentences)
    assert any("Test again" in sentence for sentence in sentences) is test_again
    assert (said.status == "act") is (ahead < 2.0)


def test_several_limits_name_the_likely_first() -> None:
    _, sentences = words(drives.wearing(drives.LOST_MOTION, drives.SECANT, drives.WIDTH))
    assert sentences[0].startswith(
        "The first limit (most likely lost motion above 2 arcmin) is forecast to be passed between "
    )


def test_one_test_says_that_the_prior_carries_it() -> None:
    _, sentences = words(drives.wearing(count=1, now=100.0, crossing=6000.0, spread=2000.0))
    assert (
        "There is one test only: how fast this drive wears comes from the prior, not from the "
        "drive." in sentences
    )


def test_after_one_test_there_is_no_date_but_that_of_the_next() -> None:
    """The tail of a prior asked to inspect a new drive within hours, and to test it before."""
    result = drives.wearing(count=1, now=100.0, crossing=6000.0, spread=2000.0)
    forecasts = tuple(replace(one, inspect_before_hours=104.0) for one in result.forecasts)
    said, sentences = words(one := replace(result, forecasts=forecasts))
    assert (said.status, said.label) == ("plan", "Plan a second test")
    assert "inspect before" not in sentences[1]
    quarter = 100.0 + forecasts[0].remaining_hours[0.25]
    assert outlook.next_test_hours(one) == pytest.approx(quarter)
    assert sentences[-1].startswith("Test again by 4 ")
    assert "(risk till then 2" in sentences[-1]
    tiles = {fact.label: fact.value for fact in facts(one)}
    assert tiles["Inspection"] == "no date yet"
    entry = fleet_entry(summary_json(one))
    assert not entry.dated
    assert entry.rank_hours == pytest.approx(quarter - 100.0)


@pytest.mark.parametrize(
    ("risk_now", "kind", "in_table"), [(0.0, "no date yet", "no date yet"), (0.08, "now", "now")]
)
@pytest.mark.parametrize("ahead", [1.0, 4.0])
def test_tables_and_pictures_of_one_test_ask_for_what_the_verdict_does(
    risk_now: float, kind: str, in_table: str, ahead: float
) -> None:
    """What a prior thinks may come within hours is not due; what is likely passed now is."""
    result = drives.wearing(count=1, now=100.0, crossing=6000.0, spread=2000.0)

    def believed(forecast: Forecast) -> Forecast:
        course = forecast.crossing_probability.copy()
        course[:, 1] = np.maximum(course[:, 1], risk_now)
        due = 100.0 + (0.0 if risk_now else ahead)
        return replace(forecast, crossing_probability=course, inspect_before_hours=due)

    one = replace(result, forecasts=tuple(map(believed, result.forecasts)))
    said, _ = words(one)
    assert said.label == {"no date yet": "Plan a second test", "now": "Act now"}[kind]
    assert outlook.inspection(one.forecasts[0], dated=outlook.dated(one)) == kind
    rows = limits_table(one).groups[0].rows
    assert {row.cells[-1] for row in rows} == {in_table}
    waits = [at for at, _ in outlook.deciding_risks(one)]
    assert 104.0 not in waits
    test = outlook.next_test_hours(one)
    assert kind == "now" or outlook.rounded_date(one.forecasts[-1], test or 0.0) in waits
    with house_style():
        life, ((_, course),) = life_picture(one), trend_pictures(one)
    asked = "inspect now" if kind == "now" else "test again"
    assert life is not None
    assert life.action.startswith(asked)
    assert course.action.startswith(asked)


def test_the_trend_of_another_limit_does_not_put_off_what_is_due() -> None:
    result = drives.wearing(drives.LOST_MOTION, drives.SECANT)
    with house_style():
        before = [course.action for _, course in trend_pictures(result)]
        lost, secant, first = result.forecasts
        due = replace(first, inspect_before_hours=first.now_hours)
        after = trend_pictures(replace(result, forecasts=(lost, secant, due)))
    assert all(action.startswith("test again before") for action in before)
    assert [course.action[:12] for _, course in after] == ["inspect now;"] * 2


def test_a_limit_on_the_side_that_wear_leaves_is_asked_about() -> None:
    """It was told as nothing to plan, however worn the drive."""
    left = replace(drives.SECANT, direction="above", threshold=60_000.0)  # it falls with wear
    told, said = words(wrong := drives.wearing(left, crossing=5000.0, never=0.97))
    asked = "above 60 000 Nm/rad does not guard the side that wear takes it to."
    assert asked in spaced(said[0])
    assert (told.status, told.label) == ("good", "Check the limits")
    assert any("does not guard the side" in text for text in summary_json(wrong)["warnings"])
    for limits in ((drives.SECANT,), (drives.LOST_MOTION,), (left, drives.SECANT)):
        assert "does not guard" not in " ".join(words(drives.wearing(*limits))[1])
    first, second, *others = wrong.tests
    eased = replace(wrong, tests=(first, replace(second, event="regreased"), *others))
    assert "does not guard" not in " ".join(words(eased)[1])


def test_what_to_do_now_comes_before_remarks_on_limits_and_pace() -> None:
    """A drive past its limit led with two limits that have nothing to do with it."""
    behind = replace(drives.SECANT, direction="above", threshold=60_000.0)  # it falls with wear
    far = Limit("hysteresis_width_arcmin", 500.0, "above")
    past = drives.past_limit()
    result = replace(past, drive=replace(past.drive, limits=(far, *past.drive.limits, behind)))
    told, said = words(result)
    assert told.status == "act"
    assert said[0].startswith("Lost motion is past its limit")
    assert said[1] == "Inspect now."
    assert [text for text in said[2:] if "check its number and unit" in text]
    assert [text for text in said[2:] if "does not guard the side" in text]
    assert spaced(fleet_entry(summary_json(result)).sentence) == said[0]
    _, alone = words(drives.wearing(count=1, crossing=700.0, spread=40.0))
    assert alone[0].startswith("Lost motion is past its limit")
    assert [text for text in alone[2:] if text.startswith("There is one test only")]
    _, fitted = words(drives.single_fit(drives.LOST_MOTION, far, wear=1.2))
    assert "past its limit" in fitted[0]
    assert fitted[1] == "Inspect now."


def test_a_limit_that_is_passed_by_a_slip_of_its_unit_is_asked_about_first() -> None:
    """What is to be done rests on it."""
    slip = replace(drives.LOST_MOTION, threshold=drives.LOST_MOTION.threshold / 3000.0)
    result = drives.wearing(slip, crossing=700.0, spread=40.0)
    told, said = words(result)
    assert told.status == "act"
    assert "check its number and unit" in said[0]
    assert said[1].startswith("Lost motion is past its limit")


def test_the_limit_that_carries_the_risk_is_named() -> None:
    """The limit with the earliest middle may have no risk at all at the date."""
    result = drives.wearing(drives.LOST_MOTION, drives.WIDTH)
    at = result.forecasts[-1].inspect_before_hours
    assert at is not None
    lost, width, first = result.forecasts
    assert outlook.deciding(result.forecasts) is lost
    course = lost.crossing_probability.copy()
    course[:, 1] = np.where(course[:, 0] < 1.5 * at, 0.0, course[:, 1])
    sure = replace(lost, crossing_probability=course)
    assert outlook.leading((sure, width, first)) is sure
    _, sentences = words(replace(result, forecasts=(sure, width, first)))
    assert sentences[0].startswith(
        "The first limit (most likely lost motion above 2 arcmin, but hysteresis width below "
    )
    assert " if soon) is forecast to be passed " in sentences[0]


def test_two_tests_say_that_they_lean_on_the_prior() -> None:
    _, sentences = words(drives.wearing(count=2))
    assert any("still leans on the prior" in sentence for sentence in sentences)


@pytest.mark.parametrize(
    ("since", "said"),
    [
        (1, "There is one test only since the drive was replaced: how fast this drive wears comes"),
        (2, "With 2 tests since the drive was replaced the pace of wear still leans on"),
    ],
)
def test_a_replaced_drive_is_told_by_its_own_tests(since: int, said: str) -> None:
    result = drives.wearing(count=5)
    tests = [replace(test, event=None) for test in result.tests]
    tests[-since] = replace(tests[-since], event="replaced")
    _, sentences = words(replace(result, tests=tuple(tests)))
    (found,) = (one for one in sentences if one.startswith(said))
    assert "the drive before it and the prior" in found


@pytest.mark.parametrize("result", [drives.wearing(), drives.past_limit()])
def test_a_trend_that_misses_a_limited_figure_is_said(result: DriveResult) -> None:
    assert result.trend is not None
    seen = (1.1, 1.15, 1.2), (1.4, 1.43, 1.46)
    keys, last = ("lost_motion_arcmin", "preload_Nm"), len(result.tests) - 1
    said = (
        "The trend does not reproduce what the last test says of lost motion: read the warnings "
        "before you rely on its forecast of it."
    )
    for tests, wanted in (((1, last), True), ((1,), False)):
        missed = tuple(NotReproduced(key, tests, 1, *seen) for key in keys)
        with_it = replace(result, trend=replace(result.trend, not_reproduced=missed))
        assert (said in words(with_it)[1]) is wanted


def test_what_did_not_converge_is_said_before_everything() -> None:
    said, sentences = words(drives.not_converged())
    assert said.provisional
    assert said.label.endswith("provisional")
    assert sentences[0] == (
        "Not converged: the fit of test t03 and the trend. The numbers below are provisional; run "
        "again with another seed before acting on them."
    )
    assert "is forecast to be passed" in sentences[1]


def test_a_quick_run_that_did_not_converge_is_to_be_run_in_full() -> None:
    result = drives.not_converged()
    quick = replace(result, provenance=replace(result.provenance, quick=True))
    assert "run again in full, not quick, before" in words(quick)[1][0]


def test_a_fit_without_limits_tells_the_present_condition() -> None:
    said, sentences = words(drives.single_fit())
    assert (said.status, said.label) == ("present", "Present condition only")
    assert sentences[0].startswith("This test shows a hysteresis width of 0.3")
    assert "arcmin (90 %: " in sentences[0]
    assert sentences[1] == "No limit is set for this drive, so that there is nothing to forecast."


def test_a_fit_with_limits_is_held_against_them() -> None:
    told = drives.single_fit().tests[0].figures["lost_motion_arcmin"]
    inside = Limit("lost_motion_arcmin", 2.0, "above")
    past = Limit("lost_motion_arcmin", 0.1, "above")
    between = Limit("lost_motion_arcmin", (told[0.75] + told[0.95]) / 2, "above")
    sentences = {
        limit.threshold: words(drives.single_fit(limit))[1][0] for limit in (inside, past, between)
    }
    assert sentences[2.0].endswith(
        "inside its limit, not above 2 arcmin, with a probability above 95 %."
    )
    assert sentences[0.1].endswith(
        "past its limit, above 0.1 arcmin, with a probability above 95 %."
    )
    assert sentences[between.threshold].endswith(
        "the probability that it is past it is between 5 and 25 %."
    )
    # A width of 0.3 arcmin is not "inside 0.2 arcmin" to whoever does not know that it falls.
    width = Limit("hysteresis_width_arcmin", 0.2, "below")
    assert "inside its limit, not below 0.2 arcmin, with" in words(drives.single_fit(width))[1][0]


def test_what_a_fit_finds_past_its_limit_comes_first_and_asks_to_inspect() -> None:
    inside = Limit("hysteresis_width_arcmin", 5.0, "above")
    past = Limit("lost_motion_arcmin", 0.1, "above")
    result = drives.single_fit(inside, past)
    said, sentences = words(result)
    assert (said.status, said.label) == ("act", "Act now")
    assert sentences[0].startswith("Lost motion is ")
    assert sentences[0].endswith("past its limit, above 0.1 arcmin, with a probability above 95 %.")
    assert sentences[1] == "Inspect now."
    assert sentences[2].startswith("Hysteresis width is ")
    assert facts(result)[0].label == "Lost motion"
    entry = fleet_entry(summary_json(result))
    assert (entry.sentence, entry.rank) == (said.sentences[0], 0)
    assert words(drives.single_fit(inside))[0].status == "present"


def test_a_figure_past_its_limit_by_the_prior_alone_is_told_and_not_acted_on() -> None:
    result = drives.single_fit(Limit("lost_motion_arcmin", 0.1, "above"))
    test = result.tests[0]
    wide = test.figures | {"lost_motion_arcmin": drives.by_level(np.linspace(0.4, 1.2, 401))}
    leans = {"lost_motion_arcmin": Sensitivity(0.6, 0.1, "prior", 0.1)}
    said, sentences = words(
        replace(result, tests=(replace(test, figures=wide, sensitivity=leans),))
    )
    assert said.status == "present"
    assert "past its limit" in sentences[0]
    assert "Inspect now." not in sentences


@pytest.mark.parametrize("direction", ["above", "below"])
def test_bounds_from_quantiles_hold_the_true_probability(direction: str) -> None:
    rng = np.random.default_rng(0)
    draws = rng.normal(10.0, 1.0, size=20_001)
    levels = drives.by_level(draws)
    for threshold in np.linspace(7.5, 12.5, 41):
        limit = Limit("preload_Nm", float(threshold), direction)  # type: ignore[arg-type]
        low, high = probability_bounds(levels, limit)
        past = np.mean(draws > threshold if direction == "above" else draws < threshold)
        assert low - 1e-3 <= past <= high + 1e-3


def test_a_shutdown_that_has_passed_is_not_stated() -> None:
    _, sentences = words(drives.wearing(shutdown=800.0))
    assert not any("shutdown" in sentence for sentence in sentences)


def test_a_shutdown_past_the_horizon_that_is_not_to_be_waited_for_is_planned_for() -> None:
    result = drives.healthy()
    settings = replace(result.drive.forecast, next_shutdown_hours=30_000.0)
    forecasts = [replace(one, probability_crossed_by_shutdown=0.48) for one in result.forecasts]
    late = replace(
        result, forecasts=tuple(forecasts), drive=replace(result.drive, forecast=settings)
    )
    said, sentences = words(late)
    assert any("is 48 %, above the accepted 5 %: do not wait for it" in text for text in sentences)
    assert said.status == "plan"


def test_a_risk_that_rounds_to_the_accepted_one_is_told_from_it() -> None:
    result = with_quantiles(
        drives.wearing(), 1460.0, 2280.0, 1310.0, probability_crossed_by_shutdown=0.0537
    )
    assert "is 5.4 %, above the accepted 5 %" in words(result)[1][1]


def test_two_tests_within_the_hour_do_not_ask_for_the_next_one_at_once() -> None:
    result = drives.healthy()
    now = result.forecasts[0].now_hours
    pair = [
        replace(test, service_hours=now - ago)
        for test, ago in zip(result.tests[-2:], (0.5, 0.0), strict=True)
    ]
    at = outlook.next_test_hours(replace(result, tests=tuple(pair)))
    assert at == pytest.approx((now + result.forecasts[0].horizon_hours) / 2.0)


def test_tests_at_one_service_hour_say_nothing_of_the_pace() -> None:
    result = drives.wearing(count=3)
    together = replace(
        result, tests=tuple(replace(test, service_hours=900.0) for test in result.tests)
    )
    _, sentences = words(together)
    assert sentences[0] == (
        "All tests are at the same service hours: how fast this drive wears comes from the prior, "
        "not from the drive."
    )
    apart = (replace(together.tests[0], service_hours=0.0), *together.tests[1:])
    _, sentences = words(replace(result, tests=apart))
    assert any(
        one.startswith("With tests at two different service hours the pace") for one in sentences
    )


def test_what_may_be_passed_already_is_not_said_to_come() -> None:
    result = drives.wearing()
    first = result.forecasts[0]
    table = first.crossing_probability.copy()
    table[:, 1] = np.maximum(table[:, 1], 0.3)
    changed = replace(
        first,
        crossing_probability=table,
        remaining_hours={0.05: 0.0, 0.25: 0.0, 0.5: 900.0, 0.75: 1200.0, 0.95: 1400.0},
        inspect_before_hours=first.now_hours,
    )
    said, sentences = words(replace(result, forecasts=(changed,)))
    assert said.status == "act"
    assert sentences[:2] == [
        "Lost motion is forecast to pass 2 arcmin before 2 300 h (95 %); with a probability of "
        "30 % that has happened already.",
        "The risk that it is passed already is 30 %; the accepted risk is 5 %: inspect now.",
    ]
    later = replace(changed, remaining_hours=changed.remaining_hours | {0.95: None})
    _, sentences = words(replace(result, forecasts=(later,)))
    assert sentences[0].startswith("Lost motion is forecast to pass 2 arcmin by 20 000 h with")
    assert sentences[0].endswith("; with a probability of 30 % that has happened already.")


def test_a_shutdown_between_the_date_and_its_rounding_is_not_contradicted() -> None:
    result = with_quantiles(
        drives.wearing(shutdown=1514.0),
        1560.0,
        2280.0,
        1528.0,
        probability_crossed_by_shutdown=0.045,
    )
    _, sentences = words(result)
    assert sentences[0].endswith("inspect before 1 500 h.")
    assert sentences[1].endswith(
        "within the accepted 5 %: it can wait till then, as the date to inspect before is rounded "
        "down."
    )


def test_a_test_that_was_past_a_limit_by_itself_is_told() -> None:
    """Tests together may say otherwise: another temperature, a bad mounting."""
    result = drives.wearing(drives.LOST_MOTION)
    [limit] = result.drive.limits
    assert not any("by itself is past" in text for text in verdict(result).sentences)
    *others, middle, last = result.tests
    figures = {limit.key: {level: limit.threshold * (1.1 + 0.1 * level) for level in LEVELS}}
    odd = replace(middle, figures={**middle.figures, **figures})
    found = verdict(replace(result, tests=(*others, odd, last)))
    [said] = [text for text in found.sentences if "by itself is past" in text]
    assert said.startswith(f"Test {odd.test_id} by itself is past the limit on lost motion, above")
