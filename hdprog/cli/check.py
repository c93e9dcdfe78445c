"""`hdprog check`: whether a record is usable, in words."""

from __future__ import annotations

import math
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
    from hdprog.config import Drive
    from hdprog.data.check import CheckReport

_FAR_OFF = 5.0  # times: an inch-pound for a Nm is 9, a degree for a radian 57 off


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
    """Add what a run refuses or doubts beside the files: prior, limits and horizon of the drive."""
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
    warnings += _stiffness_far_off(drive, report)
    if not problems:
        warnings += _limits_far_off(drive, report)
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


def _stiffness_far_off(drive: Drive, report: CheckReport) -> list[str]:
    """Say which records are far from the stiffness of the drive's model, one sentence for all."""
    from hdprog.inference.catalogue import times_expected
    from hdprog.reporting.rounding import significant
    from hdprog.reporting.words import listed

    far = {}
    for name, loop in report.loops:
        if not math.isfinite(loop.secant_stiffness):
            continue  # torque and angle unrelated, which is told
        span = loop.torque_max - loop.torque_min
        times = times_expected(drive.model, abs(loop.secant_stiffness), span, loop.sides)
        if times is not None and not 1 / _FAR_OFF <= times <= _FAR_OFF:
            far[name] = f"{significant(times)} times"
    if not far:
        return []
    return [
        f"Stiffness of {listed(f'{name} is {times}' for name, times in far.items())} that of the "
        f"catalogue for {drive.model}. Are torque and angle in their units, at the output, and of "
        "this drive? A drive that is worn out may have a quarter of it."
    ]


def _limits_far_off(drive: Drive, report: CheckReport) -> list[str]:
    """Say which limits lie nowhere near what the drive can have, and which beyond its records."""
    from hdprog.inference.expected_figures import expected_figures
    from hdprog.inference.priors import RecordScales
    from hdprog.reporting.declared_words import limits_beyond
    from hdprog.reporting.far_limits import far_from_prior
    from hdprog.reporting.reader_units import shown_in
    from hdprog.reporting.words import keyboard_signs

    loops = [loop for _, loop in report.loops if 0.0 < loop.secant_stiffness < math.inf]
    if not loops or not drive.limits:
        return []
    torques = [max(abs(loop.torque_min), abs(loop.torque_max)) for loop in loops]
    expected = expected_figures(drive, RecordScales(loops[0].secant_stiffness, torques[0]))
    with shown_in(drive.report):
        said = [*far_from_prior(drive.limits, expected), *limits_beyond(drive, max(torques))]
    return [keyboard_signs(text) for text in said]
