"""The verdict: what to do about a drive, in sentences that stand alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hdprog.reporting import outlook
from hdprog.reporting.effect_words import traced_sentences
from hdprog.reporting.end_of_wear_words import kept_by_the_end
from hdprog.reporting.far_limits import far_limits
from hdprog.reporting.fit_names import doubtful_without_effects
from hdprog.reporting.left_out import gone_sentences, left_out_sentences
from hdprog.reporting.left_structure import structure_sentences
from hdprog.reporting.limits_left_behind import limits_left_behind
from hdprog.reporting.present import (
    against_limit,
    condition,
    gravest_first,
    is_past,
    passed_at_an_event,
    past_by_itself,
    past_since,
)
from hdprog.reporting.read_off_words import missed_sentences
from hdprog.reporting.reader_units import shown_in
from hdprog.reporting.rounding import (
    hours,
    hours_up,
    percent,
    percent_beside,
    share,
    without_unit,
)
from hdprog.reporting.trend_words import passed_by
from hdprog.reporting.weak_words import prior_driven
from hdprog.reporting.words import (
    agree,
    capital,
    listed,
    quantity,
    threshold_words,
    tidy,
    with_unit,
)
from hdprog.results import DriveResult, Forecast, since_replaced

Status = Literal["act", "plan", "good", "present"]


@dataclass(frozen=True)
class Verdict:
    """What a report says first.

    Attributes
    ----------
    status : "act" now, "plan" an inspection, "good" up to the horizon, or the "present" only
    provisional : a fit or the trend did not converge
    label : the status in a few words
    sentences : in the order of their weight; together they are the verdict
    """

    status: Status
    provisional: bool
    label: str
    sentences: tuple[str, ...]

    @property
    def text(self) -> str:
        """All sentences as one text."""
        return " ".join(self.sentences)


_LIKELY_ENOUGH = 0.05  # of having been passed already: the early end of 90 % is now
_LABELS: dict[Status, str] = {
    "act": "Act now",
    "plan": "Plan an inspection",
    "good": "No limit in sight",
    "present": "Present condition only",
}


def verdict(result: DriveResult) -> Verdict:
    """Verdict on a drive: convergence first, then what to do, then what it rests on."""
    with shown_in(result.drive.report):
        return _verdict(result)


def _verdict(result: DriveResult) -> Verdict:
    sentences: list[str] = []
    if not result.converged:
        sentences.append(not_converged(result))
    main = outlook.overall(result.forecasts)
    if main is None:
        status: Status
        status, said = _present(result)
    else:
        status, said = _outlook(result, main)
        coming = outlook.not_passed(result.forecasts)
        limits = [one.limit for one in coming if one.limit and not one.already_crossed]
        said += past_by_itself(result.tests, limits)
    before, after = _remarks(result, status)
    sentences += [*before, *said, *after, *left_out_sentences(result)]
    if result.explanation is not None:
        sentences += traced_sentences(result.explanation)
        sentences += gone_sentences(result)
        alone = doubtful_without_effects(result)
        if alone and result.explanation.effects:
            sentences.append(
                f"The drive model alone did not converge in {agree(len(alone), 'test', 'tests')} "
                f"{listed(alone)}: what is said of it, without what was added, is provisional."
            )
    sentences += structure_sentences(result)
    provisional = not result.converged
    label = _label(result, status, main) + (" \u2013 provisional" if provisional else "")
    return Verdict(status, provisional, label, tuple(map(tidy, sentences)))


def _remarks(result: DriveResult, status: Status) -> tuple[list[str], list[str]]:
    """What to know of limits, fit and pace: before what is to be done, and after it.

    Where something is to be done now that leads; but a limit that is past and nowhere near what
    the drive has is what the doing rests on, and more likely a slip.
    """
    limits = result.drive.limits
    slips = [one for one in limits if status != "act" or is_past(result.tests[-1], one)]
    others = [*limits_left_behind(result), *missed_sentences(result)]
    if result.forecasts and outlook.tested_at(result) == 1:
        others.append(_no_pace(result))
    before, after = far_limits(result, slips), others
    if status != "act":
        return [*before, *after], []
    return before, [*far_limits(result, [one for one in limits if one not in slips]), *after]


def _label(result: DriveResult, status: Status, main: Forecast | None) -> str:
    if status == "plan" and not outlook.dated(result):
        return "Plan a second test"
    within = main is not None and main.remaining_hours.get(0.05) is not None
    if status == "good" and limits_left_behind(result):
        return "Check the limits"
    if status == "good" and within:  # by an accepted risk that is larger
        return "Within the accepted risk"
    return _LABELS[status]


def not_converged(result: DriveResult) -> str:
    """Which parts did not converge, and what follows from it."""
    doubtful = [test.test_id for test in result.tests if not test.converged]
    parts = []
    if doubtful:
        fits = agree(len(doubtful), "the fit of test", "the fits of tests")
        added = result.explanation is not None and any(
            test.effects for test in result.tests if not test.converged
        )
        beside = " with what was added" if added else ""
        parts.append(f"{fits} {listed(doubtful)}{beside}")
    if result.trend is not None and not result.trend.converged:
        parts.append("the trend")
    again = "in full, not quick," if result.provenance.quick else "with another seed"
    return (
        f"Not converged: {listed(parts)}. The numbers below are provisional; run again {again} "
        "before acting on them."
    )


def _present(result: DriveResult) -> tuple[Status, list[str]]:
    """Status and sentences for a fit without a forecast: the last test as it is."""
    test = result.tests[-1]
    limits = gravest_first(test, result.drive.limits)
    past = [limit for limit in limits if is_past(test, limit)]
    # What leans on the prior is not to be acted on alone, as a warning says.
    act = any(not prior_driven(test, limit.key) for limit in past)
    sentences = [against_limit(test, limit) for limit in limits]
    if act:
        sentences.insert(len(past), "Inspect now.")
    if not limits:
        which = "This test" if len(result.tests) == 1 else f"The last test, {test.test_id},"
        sentences.append(condition(test, which))
        sentences.append("No limit is set for this drive, so that there is nothing to forecast.")
    else:
        sentences.append(
            "One loop by itself says nothing of remaining life; several tests with their service "
            "hours do."
        )
    return "act" if act else "present", sentences


def _outlook(result: DriveResult, main: Forecast) -> tuple[Status, list[str]]:
    """Status and sentences for a drive with forecasts."""
    passed = outlook.passed(result.forecasts)
    if passed:
        sentences = [_passed(result, forecast) for forecast in passed]
        sentences.append("Inspect now.")
        soonest = outlook.leading(outlook.not_passed(result.forecasts))
        if soonest is not None:
            sentences.append(_coming(soonest, _subject(soonest)))
        return "act", sentences + _rests_on(result)
    sentences = [_coming(main, _main_subject(result, main))]
    if outlook.inspect_now(result, main):
        return "act", [*sentences, _due(main), *_rests_on(result)]
    if not outlook.dated(result):
        return "plan", [*sentences, *_before_a_pace(result, main)]
    status: Status = "good"
    if main.inspect_before_hours is not None:
        status = "plan"
        before = hours(outlook.rounded_date(main, main.inspect_before_hours))
        sentences[0] = f"{sentences[0].removesuffix('.')}; inspect before {before}."
    ahead = outlook.shutdown_ahead(result)
    if ahead is not None and ahead[1] > main.acceptable_risk:
        status = "plan"  # past the horizon, where no date to inspect before is given
    sentences += kept_by_the_end(result) + _shutdown(result, main) + _rests_on(result)
    at = outlook.next_test_hours(result)
    if at is not None:
        when = outlook.next_test_words(result, at)
        why = (
            ", the joint mounted anew: the date is too near for waiting to tell more"
            if when == outlook.NOW
            else ""
        )
        sentences.append(f"Test again {when}{why}.")
    return status, sentences


def _before_a_pace(result: DriveResult, main: Forecast) -> list[str]:
    """When to come back to a drive whose pace only a prior or a fleet tells."""
    said = []
    ahead = outlook.shutdown_ahead(result)
    if ahead is not None:
        risk = percent_beside(ahead[1], main.acceptable_risk)
        said.append(f"The risk by the next shutdown at {hours(ahead[0])} is then {risk}.")
    at = outlook.next_test_hours(result)
    if at is not None:
        date = outlook.rounded_date(main, at)
        chance = percent(outlook.risk_at(main, date))
        said.append(
            f"Test again by {hours(date)} (risk till then {chance}): "
            "with a second test the drive's own pace tells a date to inspect before."
        )
    return said


def _due(main: Forecast) -> str:
    """Why to inspect now although no single limit is more likely passed than not."""
    now, accepted = outlook.risk_now(main), share(main.acceptable_risk)
    risk = percent_beside(now, main.acceptable_risk)
    if now >= main.acceptable_risk:
        why = f"The risk that it is passed already is {risk}; the accepted risk is {accepted}"
    elif main.already_crossed:  # by an accepted risk above even odds
        why = f"It is more likely passed than not ({risk}), whatever risk is accepted"
    else:
        why = f"The risk that it is passed reaches the accepted {accepted} within two hours"
    return f"{why}: inspect now."


def _passed(result: DriveResult, forecast: Forecast) -> str:
    limit = forecast.limit
    if limit is None:
        raise ValueError("the first of all limits has no figure of its own")
    named = quantity(limit.key)
    sure = "" if outlook.surely_passed(forecast) else "more likely than not "
    text = (
        f"{capital(named.name)} is {sure}past its limit: {limit.direction} "
        f"{threshold_words(limit.key, limit.threshold)}"
    )
    trend = None if result.trend is None else result.trend.figures.get(limit.key)
    if trend is None:
        return text + "."
    low, middle, high = outlook.figure_now(trend, forecast)
    return (
        f"{text}; it is {with_unit(middle, named.unit)} now (90 %: {low} to {high}), past "
        f"the limit with a probability of {percent(outlook.risk_now(forecast))}."
        f"{past_since(result.tests, limit)}"
        f"{passed_at_an_event(result.tests, limit)}"
    )


def _subject(forecast: Forecast) -> tuple[str, str]:
    limit = forecast.limit
    if limit is None:
        raise ValueError("the first of all limits has no figure of its own")
    return capital(quantity(limit.key).name), outlook.passing_words(limit)


def _main_subject(result: DriveResult, main: Forecast) -> tuple[str, str]:
    """Grammatical subject and verb: the limit itself, or the first of several."""
    if main.limit is not None:
        return _subject(main)
    lead, soon = outlook.leading(result.forecasts), outlook.deciding(result.forecasts)
    if lead is None or lead.limit is None:
        return "The first limit", "be passed"
    likely = f"most likely {outlook.limit_words(lead.limit)}"
    if soon is not None and soon.limit is not None and soon is not lead:
        likely += f", but {outlook.limit_words(soon.limit)} if soon"
    return f"The first limit ({likely})", "be passed"


def _coming(forecast: Forecast, subject: tuple[str, str]) -> str:
    """When a limit is passed, for every case of quantiles inside or past the horizon."""
    name, verb = subject
    crossing, spread = outlook.crossing_hours(forecast), outlook.spread(forecast)
    early, late = crossing.get(0.05), crossing.get(0.95)
    horizon = hours(forecast.horizon_hours)
    if outlook.risk_now(forecast) >= _LIKELY_ENOUGH:
        risk = percent(outlook.risk_now(forecast))
        chance = percent(forecast.probability_crossed_by_horizon)
        when = (
            f"by {horizon} with a probability of {chance}"
            if late is None
            else f"before {hours_up(late, spread)} (95 %)"
        )
        return (
            f"{name} is forecast to {verb} {when}; with a probability of {risk} that has "
            "happened already."
        )
    if early is None:
        stays = percent(1.0 - forecast.probability_crossed_by_horizon)
        return f"{name} is not forecast to {verb} before {horizon} (probability {stays})."
    start = hours(outlook.rounded_date(forecast, early))
    if late is None:
        later = percent(1.0 - forecast.probability_crossed_by_horizon)
        return (
            f"{name} is forecast to {verb} not before {start} (95 %) and, "
            f"with a probability of {later}, later than {horizon}."
        )
    return (
        f"{name} is forecast to {verb} between "
        f"{without_unit(start)} and {hours_up(late, spread)} (90 %)."
    )


def _shutdown(result: DriveResult, main: Forecast) -> list[str]:
    ahead = outlook.shutdown_ahead(result)
    if ahead is None:
        return []
    at, risk = ahead
    accepted = share(main.acceptable_risk)
    compared = f"within the accepted {accepted}: it can wait"
    date = outlook.inspection_hours(main)
    if risk > main.acceptable_risk:
        compared = f"above the accepted {accepted}: do not wait for it"
    elif date is not None and date < at:
        compared += " till then, as the date to inspect before is rounded down"
    return [
        f"If nothing is done, the risk by the next shutdown at {hours(at)} is "
        f"{percent_beside(risk, main.acceptable_risk)}, "
        f"{compared}."
    ]


def _carrier(result: DriveResult) -> str:
    fleet = None if result.trend is None else result.trend.fleet
    carrier = "the prior" if fleet is None else "the fleet"
    replaced = len(since_replaced(result.tests)) < len(result.tests)
    return f"the drive before it and {carrier}" if replaced else carrier


def _no_pace(result: DriveResult) -> str:
    """Too little to see wear in: said before anything that is forecast."""
    own = len(since_replaced(result.tests))
    since = "" if own == len(result.tests) else " since the drive was replaced"
    seen = f"There is one test only{since}"
    if own > 1:
        seen = f"All tests{since} are at the same service hours"
    return f"{seen}: how fast this drive wears comes from {_carrier(result)}, not from the drive."


def _rests_on(result: DriveResult) -> list[str]:
    """Who carried the forecast, if not the drive's own tests, and which figures it misses."""
    carrier, said = _carrier(result), []
    if outlook.tested_at(result) == 2:
        own = len(since_replaced(result.tests))
        tests = "2 tests" if own == 2 else "tests at two different service hours"
        if own < len(result.tests):
            tests += " since the drive was replaced"
        said.append(
            f"With {tests} the pace of wear still leans on {carrier}: expect the interval to "
            "move with the next test."
        )
    missed, passed_by = _missed(result), _passed_by(result)
    for keys, what in (
        (missed, "The trend does not reproduce what the last test says of"),
        ([key for key in passed_by if key not in missed], "The trend passes by some tests of"),
    ):
        if keys:
            said.append(
                f"{what} {listed(quantity(key).name for key in keys)}: read the warnings before "
                f"you rely on its forecast of {agree(len(keys), 'it', 'them')}."
            )
    return said


def _passed_by(result: DriveResult) -> list[str]:
    """Keys of figures with a limit whose course leaves tests aside."""
    if result.trend is None:
        return []
    limited = {limit.key for limit in result.drive.limits}
    return [
        key
        for key, course in result.trend.figures.items()
        if key in limited and passed_by(key, course, result.tests)
    ]


def _missed(result: DriveResult) -> list[str]:
    """Keys of figures with a limit that the trend does not reproduce for the last test."""
    if result.trend is None:
        return []
    limited, last = {limit.key for limit in result.drive.limits}, len(result.tests) - 1
    missed = [one.key for one in result.trend.not_reproduced if last in one.tests]
    missed += [
        key
        for key, course in result.trend.figures.items()
        if last in passed_by(key, course, result.tests)
    ]
    return [key for key in dict.fromkeys(missed) if key in limited]
