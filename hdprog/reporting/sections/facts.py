"""The few numbers beside the verdict."""

from __future__ import annotations

from dataclasses import dataclass

from hdprog.reporting import outlook
from hdprog.reporting.present import gravest_first, value_words
from hdprog.reporting.rounding import hours, percent, percent_beside, share
from hdprog.reporting.words import capital, quantity
from hdprog.results import DriveResult, Forecast


@dataclass(frozen=True)
class Fact:
    """A label, its value and what to know about it."""

    label: str
    value: str
    note: str


def facts(result: DriveResult) -> list[Fact]:
    """Inspection, risk by the shutdown, next test and last test; or the present figures."""
    main = outlook.overall(result.forecasts)
    if main is None:
        return [*_present(result), _last_test(result)]
    found = [_inspection(result, main)]
    ahead = outlook.shutdown_ahead(result)
    if ahead is not None and not main.already_crossed:
        note = f"at {hours(ahead[0])}; accepted is {share(main.acceptable_risk)}"
        value = percent_beside(ahead[1], main.acceptable_risk)
        found.append(Fact("Risk by the next shutdown", value, note))
    elif not main.already_crossed:
        note = f"that a limit is passed by then; accepted is {share(main.acceptable_risk)}"
        value = percent_beside(main.probability_crossed_by_horizon, main.acceptable_risk)
        found.append(Fact(f"Risk by {hours(main.horizon_hours)}", value, note))
    at = outlook.next_test_hours(result)
    if at is not None:
        if not outlook.dated(result):
            note = "a second one tells the pace of wear"
        elif main.inspect_before_hours is not None:
            note = "half-way to the inspection"
        else:
            note = "no inspection is due before the horizon; this keeps watch"
        when = outlook.next_test_words(result, at)
        if when == outlook.NOW:
            note = f"the inspection is due within {hours(2.0 * (at - main.now_hours))}"
        found.append(Fact("Test again", when, note))
    found.append(_last_test(result))
    return found


def _inspection(result: DriveResult, main: Forecast) -> Fact:
    if main.already_crossed:
        risk = percent(outlook.risk_now(main))
        return Fact("Inspect", "now", f"a limit is passed already with a probability of {risk}")
    at = outlook.inspection_hours(main)
    if outlook.inspect_now(result, main):
        when = "already" if outlook.risk_now(main) >= main.acceptable_risk else "within two hours"
        note = f"the risk of {share(main.acceptable_risk)} is reached {when}"
        return Fact("Inspect", "now", note)
    if at is None:
        note = f"the risk stays below {share(main.acceptable_risk)} until then"
        return Fact("Inspection", f"none due by {hours(main.horizon_hours)}", note)
    if not outlook.dated(result):
        return Fact("Inspection", "no date yet", "one test does not tell the pace of wear")
    note = f"{hours(at - main.now_hours)} from now; till then the risk is within "
    return Fact("Inspect before", hours(at), note + share(main.acceptable_risk))


def _present(result: DriveResult) -> list[Fact]:
    test = result.tests[-1]
    limits = gravest_first(test, result.drive.limits)
    keys = dict.fromkeys(limit.key for limit in limits if limit.key in test.figures)
    found = []
    for key in list(keys or test.figures)[:3]:
        value, _, spread = value_words(test.figures[key], key).partition(" (")
        found.append(Fact(capital(quantity(key).name), value, spread.removesuffix(")")))
    return found


def _last_test(result: DriveResult) -> Fact:
    test = result.tests[-1]
    when = "service hours not given" if test.service_hours is None else hours(test.service_hours)
    label = "Test" if len(result.tests) == 1 else "Last test"
    return Fact(label, test.test_id, " · ".join(filter(None, [when, test.date])))
