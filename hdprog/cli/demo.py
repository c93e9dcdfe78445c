"""`hdprog demo`: the main job on a drive that ships with the program."""

from __future__ import annotations

from importlib.resources import as_file

import typer

from hdprog.cli.common import command_line, conclude, output_folder
from hdprog.cli.options import AsJson, Out, Pdf, Quick, Quiet, Seed
from hdprog.cli.progress import progress
from hdprog.shipped import shipped

DATASET = "wearing-csf-25-80"

WITH_YOUR_OWN_FILE = """
Now with your own file (columns torque_Nm and angle_rad; other names and units: --columns):
  hdprog check my-loop.csv      says whether the record is usable
  hdprog fit my-loop.csv        gives the drive's parameters, figures of merit and a report"""


def demo(
    ctx: typer.Context,
    out: Out = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    quick: Quick = False,
    quiet: Quiet = False,
    pdf: Pdf = False,
) -> None:
    """Run the main job on a shipped drive, end to end.

    The drive is a simulated one that is wearing out; its data travel with the program.
    """
    folder = output_folder(out, DATASET, "posteriors", pdf=pdf)
    from hdprog import workflow

    with as_file(shipped("datasets") / DATASET) as drive_dir, progress(quiet=quiet) as report:
        result = workflow.run(drive_dir, seed=seed, quick=quick, progress=report)
    conclude(result, folder, command_line(ctx), as_json=as_json, pdf=pdf, advice=WITH_YOUR_OWN_FILE)
