"""What a report says of a fleet whose drives' pace is steady, and of one that does not tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.reporting.sections.method import hyperparameters, method
from hdprog.reporting.sections.shrinkage import shrinkage
from hdprog.results import FleetShare, Shrinkage, SteadyShare
from hdprog.trend.joint_refit import Met
from hdprog.trend.summary import _exactness
from tests.reporting import drives
from tests.reporting.page import spaced


def caption(steady: SteadyShare | None) -> str:
    trend = drives.wearing(drives.LOST_MOTION, count=4).trend
    assert trend is not None
    levels = trend.hyperparameters["wear_rate"]
    fleet = FleetShare(("a", "b", "c"), {"wear_rate": Shrinkage(levels, levels, levels)}, ())
    table = shrinkage(replace(trend, fleet=replace(fleet, steady=steady)))
    assert table is not None
    return table.caption


def test_the_chance_of_a_steady_pace_is_told_before_and_after_the_drives_own_tests() -> None:
    said = caption(SteadyShare(3, 0.875, 0.62))
    assert said.index("88") < said.index("62")
    assert spaced(said).endswith(
        "The fleet gives this drive's pace a chance of 88 % to be steady; with the drive's own "
        "tests the chance is 62 %. Where it is not steady, it wanders like that of any drive."
    )
    assert "of them tell" not in said


@pytest.mark.parametrize(("told", "words"), [(1, "1 of them tells"), (2, "2 of them tell ")])
def test_runs_that_do_not_tell_are_counted(told: int, words: str) -> None:
    assert words in caption(SteadyShare(told, 0.7, 0.7))


def test_runs_of_an_older_version_leave_any_drives_pace_and_the_report_says_so() -> None:
    said = caption(None)
    assert "made by an older version" in said
    assert "as that of any drive" in said


def test_what_is_asked_of_the_joint_sampling_stands_beside_its_r_hat() -> None:
    """That of the fits, 1.01, stands above it in the report."""
    result = drives.wearing(drives.LOST_MOTION, count=4)
    assert result.trend is not None
    met = Met(np.zeros((2, 1)), np.zeros((2, 1, 1)), 0.77, sampled=True, rhat=1.015, ess=331.0)
    for found, words in (
        (met, "R-hat 1.015 where less than 1.1 is asked for, 331 effective draws"),
        (replace(met, rhat=None, ess=None), "its draws are weighted by the loops' own likelihoods"),
    ):
        trend = replace(result.trend, diagnostics=_exactness(found))
        passages = method(replace(result, trend=trend))
        assert words in next(one.text for one in passages if one.title == "Trend")


def test_what_a_fleet_told_is_carried_by_the_fleet_as_the_verdict_says() -> None:
    trend = drives.wearing(drives.LOST_MOTION, count=4).trend
    assert trend is not None
    trend = replace(trend, carried_by_prior=("wear_rate",))
    taught = replace(trend, fleet=FleetShare(("a", "b", "c"), {}, ()))
    for found, carrier in ((trend, "the prior"), (taught, "the fleet")):
        (group,) = hyperparameters(found).groups
        (row,) = [row for row in group.rows if row.head == "wear rate"]
        assert row.cells[-1] == carrier
