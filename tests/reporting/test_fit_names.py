"""Which of a test's two fits did not converge is said, once each."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hdprog.outcome import ExplainOutcome, Outcome
from hdprog.reporting.build import build_report
from hdprog.reporting.sections.warnings import warnings
from hdprog.results import DriveResult
from tests.reporting import explanations
from tests.reporting.page import Page

STUCK = (
    "This fit did not converge within 900 steps (largest R-hat 1.200).",
    "This fit did not converge within 600 steps (largest R-hat 1.100).",
)


@pytest.mark.parametrize(
    ("stuck", "named"),
    [
        (STUCK, ["The fit with creep", "The fit of the drive model alone"]),
        (STUCK[:1], ["The fit of the drive model alone"]),
        (STUCK[1:], ["The fit with creep"]),
    ],
)
def test_which_fit_did_not_converge_is_said_once(stuck: tuple[str, ...], named: list[str]) -> None:
    result = explanations.single(explanations.record(converged=False, warnings=stuck))
    own = tuple(text for text in stuck if text == STUCK[1])
    test = replace(result.tests[0], converged=not own, warnings=own)
    result = replace(result, tests=(test,))
    found = [text for text in warnings(result) if "did not converge" in text]
    assert [text.partition(" did not")[0] for text in found] == named
    alone = len(own) == 0
    assert ("the drive model alone, fitted to compare, did not in test t01" in method(result)) == (
        alone
    )
    # A command ends by what the outcome says: a run of a drive as an explanation of it.
    assert result.converged is alone
    for outcome in (Outcome, ExplainOutcome):
        assert not outcome(result, (), single=True).converged


def test_one_fit_is_named_where_nothing_was_added() -> None:
    result = explanations.single(explanations.adequate(converged=False, warnings=STUCK[:1]))
    test = replace(result.tests[0], converged=False, warnings=STUCK[:1])
    found = [text for text in warnings(replace(result, tests=(test,))) if "converge" in text]
    assert len(found) == 1
    assert found[0].startswith("The fit of the drive model alone did not converge within 900")


def test_which_fit_leaves_what_hangs_together_is_said() -> None:
    own, before = (
        f"What the fit leaves hangs together beyond its noise model: 130 blocks count as {count}"
        for count in (90, 40)
    )
    result = explanations.single(explanations.record(warnings=(before, own)))
    result = replace(result, tests=(replace(result.tests[0], warnings=(own,)),))
    found = [text for text in warnings(result) if "hangs together" in text]
    assert [text.partition(" hangs together")[0] for text in found] == [
        "What the fit with creep leaves",
        "What the fit of the drive model alone leaves",
    ]
    assert [text[-2:] for text in found] == ["90", "40"]


def method(result: DriveResult) -> str:
    return Page(build_report(result)).text.partition("Sampling")[2]
