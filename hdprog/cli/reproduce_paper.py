"""`hdprog reproduce-paper`: the paper's table and figures from its own numbers."""

from __future__ import annotations

import typer

from hdprog.cli.common import command_line, conclude, output_folder
from hdprog.cli.options import AsJson, Out, Quick, Quiet, Seed
from hdprog.cli.progress import progress


def reproduce_paper(
    ctx: typer.Context,
    out: Out = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    quick: Quick = False,
    quiet: Quiet = False,
) -> None:
    """Recompute the paper's table and figures.

    From the values of its Table 2, each figure with the paper's claim and what came out, and the
    parameters recovered by the posterior. Writes reproduction.json and report.html.
    """
    folder = output_folder(out, "reproduce-paper", "reproduction.json")
    from hdprog import reproducing

    with progress(quiet=quiet) as report:
        result = reproducing.reproduce_paper(seed=seed, quick=quick, progress=report)
    conclude(result, folder, command_line(ctx), as_json=as_json)
