"""`hdprog fit`: one loop, one posterior."""

from __future__ import annotations

from typing import Annotated

import typer

from hdprog.cli.common import command_line, conclude, output_folder, read_record, split_ids
from hdprog.cli.options import AsJson, Columns, DriveFile, LoopFile, Out, Quick, Quiet, Seed, Select
from hdprog.cli.progress import progress


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
    out: Out = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    quick: Quick = False,
    quiet: Quiet = False,
) -> None:
    """Fit one loop and write its report.

    Writes summary.json, report.html and posterior.nc.
    """
    folder = output_folder(out, loop.name.split(".")[0])
    record, settings = read_record(loop, drive, columns, select)
    from hdprog import workflow  # slow to import; a bad record is told before

    with progress(quiet=quiet) as report:
        result = workflow.fit(
            record,
            settings,
            effects=split_ids(effects),
            seed=seed,
            quick=quick,
            progress=report,
        )
    conclude(result, folder, command_line(ctx), as_json=as_json)
