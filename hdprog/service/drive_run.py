"""A drive folder through the workflow, with the reports that pages show, into a folder."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from hdprog.atomic import atomic_write_text
from hdprog.errors import BadInputError
from hdprog.parallel import process_executor, spread_over
from hdprog.service.pictures import write_pictures

if TYPE_CHECKING:
    from hdprog.outcome import Outcome
    from hdprog.results import DriveResult

Say = Callable[[str, float], None]
"""`say(stage, share)`: what is being done, and how much of everything is."""

# Where each stage of the workflow begins and ends, as shares of the whole.
_STAGES = {"effects": (0.02, 0.25), "fits": (0.25, 0.45), "trend": (0.45, 0.92)}
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

    try:
        outcome = workflow.run(
            order.folder, quick=order.quick, workers=order.processes, progress=progress
        )
    except BadInputError as error:
        # The folder is gone once the words are read.
        where = error.where.replace(f"{order.folder}{os.sep}", "")
        raise BadInputError(error.found, where, error.expected, error.advice) from error
    say("writing the reports", 0.92)
    outcome.write(order.out, order.command, order.processes)
    write_test_reports(outcome, order.out / "tests", order.processes)
    write_pictures(outcome.result, order.out / "pictures")


def write_test_reports(outcome: Outcome, folder: Path, workers: int | None = None) -> None:
    """Write the report of each test by itself, as the test's page shows it."""
    folder.mkdir(exist_ok=True)
    tests, result = outcome.tests, outcome.result
    alone = [_alone(result, number) for number in range(len(tests))]
    catalogues = [one.prior.catalogue for one in outcome.posteriors] or [{}] * len(tests)
    paths = [folder / f"{test.test_id}.html" for test in tests]
    with process_executor(workers if len(tests) > 1 else 1) as executor:
        spread = spread_over(executor)
        for _ in spread(_write_report, alone, catalogues, paths):
            pass


def _write_report(result: DriveResult, catalogue: Mapping[str, float], path: Path) -> None:
    from hdprog.reporting.build import build_report

    atomic_write_text(path, build_report(result, catalogue))


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
