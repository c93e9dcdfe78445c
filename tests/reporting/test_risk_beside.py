"""A risk that stands beside the accepted one is told from it, wherever it is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hdprog.reporting.sections.facts import facts
from hdprog.reporting.sections.remaining_life import limits_table
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives
from tests.reporting.page import spaced


def with_risks(
    now: float, horizon: float, accepted: float, inspect: float | None = None
) -> DriveResult:
    """Drive with these risks at now and by the horizon."""
    result = drives.wearing(crossing=30_000.0, shutdown=None, count=2, samples=600)
    table = result.forecasts[0].crossing_probability.copy()
    table[:, 1] = np.linspace(now, horizon, len(table))
    changed = replace(
        result.forecasts[0],
        acceptable_risk=accepted,
        inspect_before_hours=inspect,
        probability_crossed_by_horizon=horizon,
        crossing_probability=table,
    )
    return replace(result, forecasts=(changed,))


def test_the_risk_by_the_horizon() -> None:
    result = with_risks(0.0, 0.048, 0.05)
    stays, by_then = facts(result)[:2]
    assert spaced(stays.note) == "the risk stays below 5 % until then"
    assert spaced(by_then.value) == "4.8 %"
    cells = limits_table(result).groups[0].rows[0].cells
    assert spaced(str(cells[2])) == "4.8 %"


def test_the_risk_at_now() -> None:
    said = verdict(with_risks(0.007, 0.04, 0.005, inspect=900.0))
    assert (
        "The risk that it is passed already is 0.7 %; the accepted risk is 0.5 %: inspect now."
        in spaced(said.text)
    )
