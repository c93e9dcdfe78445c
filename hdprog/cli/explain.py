"""`hdprog explain`: residual, missing effect, refit, error before and after."""

from __future__ import annotations

import typer

from hdprog.cli.common import command_line, conclude_fits, output_folder, read_record
from hdprog.cli.options import (
    AngleUnit,
    AsJson,
    Columns,
    DriveFile,
    LoopOrFolder,
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


def explain(
    ctx: typer.Context,
    record: LoopOrFolder,
    drive: DriveFile = None,
    columns: Columns = None,
    select: Select = None,
    out: Out = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    quick: Quick = False,
    quiet: Quiet = False,
    pdf: Pdf = False,
    angle_unit: AngleUnit = None,
    torque_unit: TorqueUnit = None,
) -> None:
    """Trace a residual to the effect that the model lacks.

    Refits with the effect and shows the error before and after. The tests of a drive folder are
    pooled. Writes explain.json, summary.json, report.html and the posteriors.
    """
    of_drive = record.is_dir()
    if of_drive and (drive is not None or columns is not None or select is not None):
        raise UsageError(
            "--drive, --columns, --select: found beside a drive folder, whose drive.toml says "
            "these things. Leave them out, or name a loop file."
        )
    units = wanted_units(angle_unit, torque_unit)
    name = record.resolve().name if of_drive else record_name(record.name)
    folder = output_folder(out, name, "posteriors" if of_drive else "posterior.nc", pdf=pdf)
    if of_drive:
        from hdprog import workflow

        with progress(quiet=quiet) as report:
            result = workflow.explain(record, seed=seed, quick=quick, progress=report)
    else:
        loop, settings = read_record(record, drive, columns, select)
        from hdprog import workflow  # slow to import; a bad record is told before

        with progress(quiet=quiet) as report:
            result = workflow.explain(loop, settings, seed=seed, quick=quick, progress=report)
    conclude_fits(result, units, folder, command_line(ctx), as_json=as_json, pdf=pdf)
