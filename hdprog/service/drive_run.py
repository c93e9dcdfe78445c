"""A drive folder through the workflow, with the reports that pages show, into a folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from hdprog.atomic import atomic_write_text
from hdprog.service.pictures import write_pictures

if TYPE_CHECKING:
    from hdprog.outcome import Outcome
    from hdprog.results import DriveResult

Say = Callable[[str, float], None]
"""`say(stage, share)`: what is being done, and how much of everything is."""

# Where each stage of the workflow begins and ends, as shares of the whole.
_STAGES = {"effects": (0.02, 0.35), "fits": (0.35, 0.80), "trend": (0.80, 0.92)}
_WORDS = {"effects": "looking for effects", "trend": "following the trend"}


@dataclass(frozen=True)
class Order:
    """What to run.

    Attributes
    ----------
    folder : a drive folder
    out : where the results go; it appears whole
    quick : fewer draws
    processes : to use at most
    command : for the provenance in the report
    """

    folder: Path
    out: Path
    quick: bool
    processes: int
    command: str


def run_here(order: Order, say: Say) -> None:
    """Run the workflow on this machine and write summary, reports and posteriors.

    Raises
    ------
    HdprogError
        for a drive folder that cannot be used
    """
    from hdprog import workflow

    say("starting", 0.01)

    def progress(stage: str, done: int, total: int) -> None:
        start, end = _STAGES[stage]
        words = _WORDS.get(stage) or f"fitted {done} of {total} tests"
        say(words, start + (end - start) * done / max(total, 1))

    outcome = workflow.run(
        order.folder, quick=order.quick, workers=order.processes, progress=progress
    )
    say("writing the reports", 0.92)
    outcome.write(order.out, order.command, order.processes)
    write_test_reports(outcome, order.out / "tests")
    write_pictures(outcome.result, order.out / "pictures")


def write_test_reports(outcome: Outcome, folder: Path) -> None:
    """Write the report of each test by itself, as the test's page shows it."""
    from hdprog.reporting.build import build_report

    folder.mkdir(exist_ok=True)
    for number, test in enumerate(outcome.tests):
        alone = _alone(outcome.result, number)
        prior = outcome.posteriors[number].prior if outcome.posteriors else None
        report = build_report(alone, {} if prior is None else prior.catalogue)
        atomic_write_text(folder / f"{test.test_id}.html", report)


def _alone(result: DriveResult, number: int) -> DriveResult:
    """Give one test of a drive as the result of a single fit."""
    from hdprog.explanation import DriveExplanation

    test, explanation = result.tests[number], result.explanation
    if isinstance(explanation, DriveExplanation):
        explanation = explanation.tests[number]
    return replace(
        result,
        tests=(test,),
        trend=None,
        forecasts=(),
        scenarios=(),
        explanation=explanation,
    )
