"""`hdprog check`: whether a record is usable, in words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from hdprog.cli.common import print_json
from hdprog.cli.exits import ExitCode
from hdprog.cli.options import (
    AsJson,
    Columns,
    DriveFile,
    IdleQuick,
    IdleQuiet,
    IdleSeed,
    LoopsOrFolders,
    Select,
)
from hdprog.errors import UsageError

if TYPE_CHECKING:
    from hdprog.data.check import CheckReport


def check(
    paths: LoopsOrFolders,
    columns: Columns = None,
    select: Select = None,
    drive: DriveFile = None,
    as_json: AsJson = False,
    _seed: IdleSeed = 0,
    _quick: IdleQuick = False,
    _quiet: IdleQuiet = False,
) -> None:
    """Say whether loop files or drive folders are usable.

    What was found and what is wrong, in words; ends with code 3 when a problem was found.
    """
    from hdprog.data.check import check_path

    if drive is not None and all(path.is_dir() for path in paths):
        raise UsageError(
            f"--drive: found {drive} beside drive folders alone, expected a loop file to compare "
            "with it. A drive folder is checked by its own drive.toml: leave --drive out."
        )
    checks = [
        _as_a_run_would(check_path(path, columns=columns, select=select, drive=drive), drive)
        for path in paths
    ]
    if as_json:
        content = [outcome.as_json() for outcome in checks]
        print_json({"schema": "hdprog.check/1", "checks": content})
    else:
        for outcome in checks:
            for line in outcome.lines:
                typer.echo(line)
    if not all(outcome.ok for outcome in checks):
        raise typer.Exit(ExitCode.BAD_INPUT)


def _as_a_run_would(report: CheckReport, drive_file: Path | None) -> CheckReport:
    """Add what a run refuses beside the files: prior, limits and horizon of the drive."""
    place = report.path if report.kind == "drive" else drive_file
    if place is None:
        return report
    from hdprog.config import read_drive
    from hdprog.data.tests_table import read_tests
    from hdprog.errors import BadInputError
    from hdprog.forecast.horizon import require_horizon
    from hdprog.inference.catalogue import ratio_doubt
    from hdprog.inference.prior_file import name_of_model, require_prior

    try:
        drive = read_drive(place)
        tests = read_tests(report.path)[0] if report.kind == "drive" else ()
    except BadInputError:
        return report  # told already
    problems: list[str] = []
    try:
        require_prior(drive)
    except BadInputError as error:
        problems.append(str(error))
    if tests:
        try:
            require_horizon(drive, tests)
        except BadInputError as error:
            problems.append(str(error))
    warnings: list[str] = []
    if drive.prior is None and drive.model is not None and name_of_model(drive.model) is None:
        warnings.append(
            f"No prior is known for model {drive.model}: it will be centred on the record. "
            "`hdprog prior list` shows the models that have one."
        )
    ratio = ratio_doubt(drive.model, drive.ratio)
    if ratio is not None:
        warnings.append(ratio)
    return replace(
        report,
        lines=(
            *report.lines,
            *(f"Problem: {problem}" for problem in problems),
            *(f"Warning: {warning}" for warning in warnings),
        ),
        problems=(*report.problems, *problems),
        warnings=(*report.warnings, *warnings),
    )
