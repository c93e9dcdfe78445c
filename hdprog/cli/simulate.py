"""`hdprog simulate`: a drive folder whose truth is known."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from hdprog.cli.common import command_line, output_folder, print_json
from hdprog.cli.options import AsJson, IdleQuick, IdleQuiet, Seed


class Wear(StrEnum):
    """How the simulated drive fares over its tests."""

    WEARING = "wearing"
    HEALTHY = "healthy"


def simulate(
    ctx: typer.Context,
    out: Annotated[Path, typer.Option("--out", help="Drive folder to make.")],
    tests: Annotated[int, typer.Option("--tests", min=1, help="Number of tests.")] = 10,
    hours: Annotated[
        float,
        typer.Option(
            "--hours",
            min=0.0,
            max=1e7,
            help="Service hours at the last of several tests; the first is at 0.",
        ),
    ] = 900.0,
    wear: Annotated[Wear, typer.Option("--wear", help="How the drive fares.")] = Wear.WEARING,
    cycles: Annotated[int, typer.Option("--cycles", min=1, help="Loading cycles a test.")] = 3,
    samples: Annotated[
        int, typer.Option("--samples", min=20, help="Samples a test, over all its cycles.")
    ] = 900,
    max_torque: Annotated[
        float, typer.Option("--max-torque", min=0.0, help="Largest torque of the loop, in Nm.")
    ] = 63.0,
    one_sided: Annotated[
        bool, typer.Option("--one-sided", help="Load in one direction only.")
    ] = False,
    effects: Annotated[
        list[str] | None,
        typer.Option("--effect", metavar="ID", help="Effect to add; may be given again."),
    ] = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    _quick: IdleQuick = False,
    _quiet: IdleQuiet = False,
) -> None:
    """Make a drive folder with known truth.

    Writes drive.toml, tests.csv, loops/*.csv and truth.json, which holds what was put in.
    """
    from hdprog.data.synthetic import write_drive_folder

    named = out.name not in ("", "..")  # the folder's name becomes the drive's id
    folder = write_drive_folder(
        output_folder(out if named else out.resolve(), "simulated"),
        seed=seed,
        scenario=wear.value,
        tests=tests,
        hours=hours,
        cycles=cycles,
        samples=samples,
        max_torque_Nm=max_torque,
        one_sided=one_sided,
        command=command_line(ctx),
        effects=tuple(effects or ()),
    )
    truth = folder / "truth.json"
    if as_json:
        print_json(json.loads(truth.read_text(encoding="utf-8")))
    else:
        typer.echo(f"Drive folder: {folder}")
        typer.echo(f"Truth: {truth}")
