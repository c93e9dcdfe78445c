"""The report says how much of a forecast rests on where wear ends."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hdprog.reporting.end_of_wear_words import end_of_wear
from hdprog.reporting.sections.remaining_life import limits_table
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives


def held_up(result: DriveResult, share: float) -> DriveResult:
    """The same with every limit held up so often by the end of wear."""
    forecasts = tuple(
        replace(
            one,
            probability_crossed_by_horizon=0.9 * (1.0 - share),
            probability_held_up_by_end_of_wear=share,
        )
        for one in result.forecasts
    )
    return replace(result, forecasts=forecasts)


def test_what_hardly_counts_is_not_told() -> None:
    assert end_of_wear(held_up(drives.wearing(), 0.04)) == ""


def test_each_limit_that_it_holds_up_is_told_with_both_risks() -> None:
    result = held_up(drives.wearing(), 0.3)
    told = end_of_wear(result)
    assert "is an assumption that no test of this drive bears out" in told
    assert told.count("93\u202f% instead of 63\u202f%") == len(result.drive.limits)
    table = limits_table(result)
    assert table is not None
    assert told in table.caption


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_a_risk_that_the_end_of_wear_alone_keeps_is_told_first(share: float) -> None:
    said = verdict(held_up(drives.healthy(), share)).text
    assert ("That rests on where wear is assumed to come to an end" in said) == (share > 0.0)
