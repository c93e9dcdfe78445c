"""`hdprog check`: whether a record is usable, in words."""

from __future__ import annotations

import typer

from hdprog.cli.common import print_json
from hdprog.cli.exits import ExitCode
from hdprog.cli.options import AsJson, Columns, DriveFile, LoopsOrFolders, Select


def check(
    paths: LoopsOrFolders,
    columns: Columns = None,
    select: Select = None,
    drive: DriveFile = None,
    as_json: AsJson = False,
) -> None:
    """Say whether loop files or drive folders are usable.

    What was found and what is wrong, in words; ends with code 3 when a problem was found.
    """
    from hdprog.data.check import check_path

    checks = [check_path(path, columns=columns, select=select, drive=drive) for path in paths]
    if as_json:
        content = [outcome.as_json() for outcome in checks]
        print_json({"schema": "hdprog.check/1", "checks": content})
    else:
        for outcome in checks:
            for line in outcome.lines:
                typer.echo(line)
    if not all(outcome.ok for outcome in checks):
        raise typer.Exit(ExitCode.BAD_INPUT)
