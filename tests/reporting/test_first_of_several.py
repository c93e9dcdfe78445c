"""Several limits, none of which is more likely passed than not, but the first of them is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hdprog.reporting.figures.remaining_life import _events, remaining_life
from hdprog.reporting.outlook import not_passed, passed
from hdprog.reporting.sections.facts import facts
from hdprog.reporting.sections.remaining_life import limits_table
from hdprog.reporting.sections.table import Value
from hdprog.reporting.style import house_style
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives
from tests.reporting.page import spaced

_NOW = 900.0
_PASSED = (0.35, 0.34)  # of each limit; 57 % of the first of the two


def two_limits(accepted: float) -> DriveResult:
    """Drive with two independent limits, each passed already on about a third of the paths."""
    limits = (drives.LOST_MOTION, drives.SECANT)
    result = drives.wearing(*limits, risk=accepted, samples=600)
    rng = np.random.default_rng(1)
    each = [
        np.where(rng.random(4000) < share, _NOW, _NOW + 10.0 + 3000.0 * rng.random(4000))
        for share in _PASSED
    ]
    told = [
        drives.forecast_of(limit, hours, _NOW, risk=accepted)
        for limit, hours in zip((*limits, None), (*each, np.min(each, axis=0)), strict=True)
    ]
    return replace(
        result,
        forecasts=tuple(
            replace(one, inspect_before_hours=_NOW) if one.already_crossed else one for one in told
        ),
    )


def test_the_words_do_not_wait_for_an_accepted_risk_above_even_odds() -> None:
    result = two_limits(0.6)
    assert [forecast.already_crossed for forecast in result.forecasts] == [False, False, True]
    said = verdict(result)
    assert said.status == "act"
    assert spaced(said.sentences[1]) == (
        "It is more likely passed than not (57 %), whatever risk is accepted: inspect now."
    )
    assert spaced(facts(result)[0].note) == "a limit is passed already with a probability of 57 %"
    first = limits_table(result).groups[0].rows[-1]
    assert first.cells[1] == Value("passed already", "57\u202f%")


def test_an_accepted_risk_that_is_reached_is_told() -> None:
    assert spaced(verdict(two_limits(0.05)).sentences[1]) == (
        "The risk that it is passed already is 57 %; the accepted risk is 5 %: inspect now."
    )


def test_the_picture_of_remaining_life_is_that_of_the_first_limit() -> None:
    result = two_limits(0.6)
    assert not_passed(result.forecasts) == result.forecasts
    with house_style():
        drawn = remaining_life(not_passed(result.forecasts), drives.SHUTDOWN, doubtful=False)
    said = spaced(drawn.alt)
    assert said.startswith("The first limit: ")
    assert "passed already with a probability of 57 %" in said
    assert drawn.action.startswith("inspect now.")


def test_a_limit_that_is_passed_by_itself_leaves_the_others_to_the_picture() -> None:
    result = drives.wearing(drives.LOST_MOTION, drives.SECANT, crossing=700.0, spread=40.0)
    over, _, first = result.forecasts
    assert (over.already_crossed, first.already_crossed) == (True, True)
    assert all(not one.already_crossed for one in not_passed(result.forecasts))


def test_a_picture_without_the_passed_limit_says_so_and_does_not_put_off_the_inspection() -> None:
    """It marked "inspect before" the hour of the limit to come under the words "inspect now"."""
    result = drives.past_limit()
    to_come = drives.forecast_of(drives.SECANT, np.linspace(1500.0, 2500.0, 400), _NOW)
    assert to_come.inspect_before_hours is not None
    with house_style():
        drawn = remaining_life(
            (to_come,), drives.SHUTDOWN, doubtful=False, passed=passed(result.forecasts)
        )
        events = _events(to_come, drives.SHUTDOWN, dated=False)
    said = spaced(drawn.alt)
    assert said.startswith("Secant stiffness")
    assert said.endswith("Lost motion above 2 arcmin is passed already, and not in this picture.")
    assert drawn.action.startswith("inspect now.")
    assert not any("inspect before" in event.label for event in events)
