"""`hdprog compare`: every model on one loop."""

from __future__ import annotations

from typing import Annotated

import typer

from hdprog.cli.common import command_line, conclude, output_folder, read_record
from hdprog.cli.options import (
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
)
from hdprog.cli.progress import progress
from hdprog.data.record_name import record_name


def compare(
    ctx: typer.Context,
    loop: LoopFile,
    drive: DriveFile = None,
    columns: Columns = None,
    select: Select = None,
    out: Out = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    quick: Quick = False,
    quiet: Quiet = False,
    pdf: Pdf = False,
    workers: Annotated[
        int | None,
        typer.Option("--workers", min=1, help="Processes to use (default: one a core)."),
    ] = None,
) -> None:
    """Compare the drive model with other models on one loop.

    Fits every model that the record allows and ranks them by what they predict of parts that they
    did not see. Writes compare.json and report.html.
    """
    folder = output_folder(out, f"compare-{record_name(loop.name)}", "compare.json", pdf=pdf)
    record, settings = read_record(loop, drive, columns, select)
    from hdprog import comparing  # slow to import; a bad record is told before

    with progress(quiet=quiet) as report:
        result = comparing.compare(
            record, settings, seed=seed, quick=quick, workers=workers, progress=report
        )
    conclude(result, folder, command_line(ctx), as_json=as_json, pdf=pdf)
