"""`hdprog fit`: one loop, one posterior."""

from __future__ import annotations

from typing import Annotated

import typer

from hdprog.cli.common import command_line, conclude_fits, output_folder, read_record, split_ids
from hdprog.cli.options import (
    AngleUnit,
    AsJson,
    Columns,
    DriveFile,
    LoopFile,
    Out,
    Pdf,
    Quick,
    Quiet,
    Seed,
    Select,
    TorqueUnit,
)
from hdprog.cli.progress import progress
from hdprog.cli.report_units import wanted_units
from hdprog.data.record_name import record_name
from hdprog.errors import UsageError


def fit(
    ctx: typer.Context,
    loop: LoopFile,
    drive: DriveFile = None,
    columns: Columns = None,
    select: Select = None,
    effects: Annotated[
        str | None,
        typer.Option("--effects", metavar="ID,ID", help="Effects to fit beside the drive model."),
    ] = None,
    method: Annotated[
        str,
        typer.Option(
            "--method",
            metavar="posterior|paper",
            help="paper: the paper's five points and least squares beside the posterior.",
        ),
    ] = "posterior",
    out: Out = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    quick: Quick = False,
    quiet: Quiet = False,
    pdf: Pdf = False,
    angle_unit: AngleUnit = None,
    torque_unit: TorqueUnit = None,
) -> None:
    """Fit one loop and write its report.

    Writes summary.json, report.html and posterior.nc.
    """
    if method not in ("posterior", "paper"):
        raise UsageError(f"--method: found {method!r}, expected posterior or paper")
    units = wanted_units(angle_unit, torque_unit)
    folder = output_folder(out, record_name(loop.name), "posterior.nc", pdf=pdf)
    record, settings = read_record(loop, drive, columns, select)
    from hdprog import workflow  # slow to import; a bad record is told before

    with progress(quiet=quiet) as report:
        result = workflow.fit(
            record,
            settings,
            effects=split_ids(effects),
            method="paper" if method == "paper" else "posterior",
            seed=seed,
            quick=quick,
            progress=report,
        )
    advice = None
    if method == "paper":
        advice = "The paper's own identification stands beside the posterior under Parameters."
    conclude_fits(result, units, folder, command_line(ctx), as_json=as_json, pdf=pdf, advice=advice)
