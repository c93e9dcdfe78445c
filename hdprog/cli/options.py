"""Arguments and options that several commands share: each is named and explained here alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hdprog.seeds import LARGEST_SEED

LoopFile = Annotated[
    Path,
    typer.Argument(metavar="LOOP", readable=False, help="A loop file (CSV, TSV, gzip, xlsx)."),
]
LoopOrFolder = Annotated[
    Path,
    typer.Argument(metavar="LOOP|DRIVE_DIR", readable=False, help="A loop file or a drive folder."),
]
LoopsOrFolders = Annotated[
    list[Path],
    typer.Argument(metavar="PATH...", readable=False, help="Loop files or drive folders."),
]
DriveFolder = Annotated[
    Path,
    typer.Argument(
        metavar="DRIVE_DIR", readable=False, help="A folder with drive.toml, tests.csv and loops/."
    ),
]
Seed = Annotated[
    int,
    typer.Option(
        "--seed",
        min=0,
        max=LARGEST_SEED,
        help="Seed of everything random: same seed, same input, same machine, same numbers.",
    ),
]
AsJson = Annotated[
    bool,
    typer.Option("--json", help="Write the JSON to standard output, and nothing else there."),
]
Quick = Annotated[
    bool,
    typer.Option("--quick", help="Fewer draws; the report is marked as quick."),
]
Quiet = Annotated[
    bool,
    typer.Option("--quiet", help="Show no progress."),
]
# The common options belong to every command, so that scripts need not tell commands apart.
_IDLE = "Taken as by other commands; changes nothing here."
IdleSeed = Annotated[int, typer.Option("--seed", min=0, max=LARGEST_SEED, hidden=True, help=_IDLE)]
IdleQuick = Annotated[bool, typer.Option("--quick", hidden=True, help=_IDLE)]
IdleQuiet = Annotated[bool, typer.Option("--quiet", hidden=True, help=_IDLE)]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        help="Folder to write to (default: ./hdprog-NAME; backtest, compare and fleet: "
        "./hdprog-COMMAND-NAME).",
    ),
]
Pdf = Annotated[
    bool,
    typer.Option("--pdf", help="Write report.pdf beside report.html (extra `pdf`)."),
]
AngleUnit = Annotated[
    str | None,
    typer.Option(
        "--angle-unit",
        metavar="UNIT",
        help="Unit of angles in the report: arcmin, arcsec, deg, mrad or rad.",
    ),
]
TorqueUnit = Annotated[
    str | None,
    typer.Option(
        "--torque-unit",
        metavar="UNIT",
        help="Unit of torques in the report: Nm, in-lbf or ft-lbf.",
    ),
]
DriveFile = Annotated[
    Path | None,
    typer.Option(
        "--drive", readable=False, help="drive.toml with the drive's model, limits and noise."
    ),
]
Columns = Annotated[
    str | None,
    typer.Option(
        "--columns",
        help="Which column is what, with its unit: torque=TORQUE:Nm,angle=POSITION:rev,time=TIME:s",
    ),
]
Select = Annotated[
    str | None,
    typer.Option(
        "--select", help="Keep only rows where a column has these values: test_nr=100,101"
    ),
]
