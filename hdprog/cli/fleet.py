"""`hdprog fleet`: every drive below a folder, and one list of them all, worst first."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hdprog.beside_report import require_no_drive_files
from hdprog.cli.common import command_line, output_folder, print_json
from hdprog.cli.exits import ExitCode
from hdprog.cli.options import AsJson, Out, Quick, Quiet, Seed
from hdprog.cli.progress import progress


def fleet(
    ctx: typer.Context,
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", readable=False, help="A folder with drive folders below it."),
    ],
    workers: Annotated[
        int | None,
        typer.Option("--workers", min=1, help="Drives to run at once (default: one a core)."),
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(
            "--dask",
            metavar="ADDRESS",
            help="Run the drives on the cluster of this Dask scheduler, tcp://HOST:8786.",
        ),
    ] = None,
    no_explain: Annotated[
        bool,
        typer.Option("--no-explain", help="Leave out the search for effects that the model lacks."),
    ] = False,
    out: Out = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    quick: Quick = False,
    quiet: Quiet = False,
) -> None:
    """Run the drives below a folder and list them, worst first.

    Each drive goes through `hdprog run`. Writes drives/NAME/ for each, fleet.json and index.html.
    Drives whose results are there already, from the same files and options, are not run again;
    drives that cannot be used are left out and listed with the reason.
    """
    place = output_folder(out, f"fleet-{folder.resolve().name}")
    require_no_drive_files(place, f"--out {place}")
    from hdprog import fleet_run
    from hdprog.reporting.words import keyboard_signs

    with progress(quiet=quiet) as report:
        found = fleet_run.run_fleet(
            folder,
            place,
            seed=seed,
            quick=quick,
            explain=not no_explain,
            workers=workers,
            dask=dask,
            command=command_line(ctx),
            progress=report,
        )
    for warning in found.content["warnings"]:
        typer.echo(f"Warning: {keyboard_signs(warning)}", err=True)
    if as_json:
        print_json(found.content)
    else:
        typer.echo(keyboard_signs(found.sentence))
        for one in found.content["left_out"]:
            typer.echo(f"Left out: {one['folder']}: {one['reason']}", err=True)
        typer.echo(f"List: {place / 'index.html'}")
    if found.broken:
        raise typer.Exit(ExitCode.BUG)
    if not found.converged:
        typer.echo(
            "Not converged: the numbers of the drives that the list marks are provisional.",
            err=True,
        )
        raise typer.Exit(ExitCode.NOT_CONVERGED)
