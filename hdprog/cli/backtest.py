"""`hdprog backtest`: how good the forecasts from earlier tests would have been."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hdprog.cli.common import command_line, conclude, output_folder
from hdprog.cli.options import AsJson, Out, Pdf, Quick, Quiet, Seed
from hdprog.cli.progress import progress


def backtest(
    ctx: typer.Context,
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DRIVE_DIR|FLEET_DIR",
            readable=False,
            help="A drive folder, or a folder with several below it, which are scored together.",
        ),
    ],
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
    """Score forecasts that earlier tests would have given.

    From each test but the last, forecasts the drive's limits with the tests up to there, and
    scores that by what came later: the later tests, or the truth of a simulated drive. Fits with
    the drive model alone. Writes backtest.json and report.html.
    """
    place = output_folder(out, f"backtest-{folder.resolve().name}", "backtest.json", pdf=pdf)
    from hdprog import backtesting

    with progress(quiet=quiet) as report:
        result = backtesting.backtest(
            folder, seed=seed, quick=quick, workers=workers, progress=report
        )
    conclude(result, place, command_line(ctx), as_json=as_json, pdf=pdf)
