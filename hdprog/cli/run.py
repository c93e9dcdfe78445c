"""`hdprog run`: the main job, a drive's tests to a forecast."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hdprog.cli.common import command_line, conclude_fits, output_folder
from hdprog.cli.options import (
    AngleUnit,
    AsJson,
    DriveFolder,
    Out,
    Pdf,
    Quick,
    Quiet,
    Seed,
    TorqueUnit,
)
from hdprog.cli.progress import progress
from hdprog.cli.report_units import wanted_units


def run(
    ctx: typer.Context,
    drive_dir: DriveFolder,
    no_explain: Annotated[
        bool,
        typer.Option("--no-explain", help="Leave out the search for effects that the model lacks."),
    ] = False,
    load: Annotated[
        list[float] | None,
        typer.Option(
            "--load",
            metavar="SHARE",
            help="Forecast also for a torque to come of this share of the torque so far (0.8 is "
            "80 %); may be given several times.",
        ),
    ] = None,
    fleet: Annotated[
        Path | None,
        typer.Option(
            "--fleet",
            metavar="DIR",
            help="Learn the pace, clock and scatter of wear from the finished runs of other drives "
            "below DIR.",
        ),
    ] = None,
    out: Out = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    quick: Quick = False,
    quiet: Quiet = False,
    pdf: Pdf = False,
    angle_unit: AngleUnit = None,
    torque_unit: TorqueUnit = None,
) -> None:
    """Fit a drive's tests and forecast its limits.

    Looks for effects that the drive model lacks, fits every test, follows the wear over service
    hours and forecasts when each limit is crossed. Writes summary.json, explain.json, report.html
    and posteriors/*.nc.
    """
    units = wanted_units(angle_unit, torque_unit)
    folder = output_folder(out, drive_dir.resolve().name, "posteriors", pdf=pdf)
    from hdprog import workflow

    with progress(quiet=quiet) as report:
        result = workflow.run(
            drive_dir,
            seed=seed,
            quick=quick,
            explain=not no_explain,
            loads=tuple(load or ()),
            fleet=fleet,
            progress=report,
        )
    conclude_fits(result, units, folder, command_line(ctx), as_json=as_json, pdf=pdf)
