"""What several commands do at their beginning and at their end."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import typer

from hdprog.atomic import can_write_into
from hdprog.beside_report import require_no_drive_files, require_no_other_report
from hdprog.cli.exits import ExitCode
from hdprog.errors import UsageError

if TYPE_CHECKING:
    from hdprog.config import Drive, ReportSettings
    from hdprog.data.loop import Loop
    from hdprog.outcome import Outcome


class Writable(Protocol):
    """What the workflow hands back: an outcome that can be written and summed up."""

    @property
    def converged(self) -> bool:
        """Whether every fit converged."""

    @property
    def sentence(self) -> str:
        """The outcome in one sentence."""

    def write(self, out: Path, command: str) -> None:
        """Write the summary, the report and the posteriors into `out`."""

    def document(self) -> dict[str, Any]:
        """What --json prints."""


def command_line(ctx: typer.Context) -> str:
    """Give the command as it was typed."""
    return str(ctx.find_root().obj)


def output_folder(
    out: Path | None, name: str, beside: str | None = None, *, pdf: bool = False
) -> Path:
    """Settle where to write, and refuse before the work what could not be written after it.

    Parameters
    ----------
    out : Path or None
        The folder asked for; None for `./hdprog-NAME`.
    name : str
        Of the drive or loop, or of the command and it.
    beside : str or None
        What is written beside report.html; None where there is no report.html.
    pdf : bool
        Whether a PDF is wanted.

    Raises
    ------
    UsageError
        When a file or a link to nothing lies where the folder or one above it should be, nothing
        can be written there, or a PDF cannot be made here.
    BadInputError
        When the folder is a drive's own, or holds the results of another command, whose report
        would be lost.
    """
    if pdf:
        from hdprog.reporting.pdf import require_pdf

        require_pdf()
    folder = Path(f"hdprog-{name}") if out is None else out
    if folder.is_symlink() and not folder.exists():
        raise UsageError(
            f"--out: found a link at {folder} whose target is not there, expected a folder or "
            "nothing there. Give another folder with --out DIR."
        )
    there = nearest_folder(folder)
    if not can_write_into(there):
        raise UsageError(
            f"--out: found the folder {there}, in which nothing can be written, expected one that "
            "can. Give another folder with --out DIR."
        )
    if beside is not None:
        require_no_drive_files(folder, f"--out {folder}")
        require_no_other_report(folder, beside, f"--out {folder}")
    return folder


def nearest_folder(
    folder: Path, option: str = "--out", advice: str = "Give another folder with --out DIR."
) -> Path:
    """Give a folder that is to be written into, or the first above it that is there.

    Raises
    ------
    UsageError
        When that is a file.
    """
    there = next(one for one in (folder, *folder.resolve().parents) if one.exists())
    if not there.is_dir():
        raise UsageError(
            f"{option}: found a file at {there}, expected a folder or nothing there. {advice}"
        )
    return there


def read_record(
    path: Path, drive: Path | None, columns: str | None, select: str | None
) -> tuple[Loop, Drive | None]:
    """Read a loop file, and the drive.toml that declares its drive where one is given.

    Raises
    ------
    BadInputError
        When one of the two files cannot be used.
    """
    from hdprog.config import read_drive
    from hdprog.data.readers import read_loop

    settings = None if drive is None else read_drive(drive)
    return read_loop(path, columns=columns, select=select, drive=settings), settings


def split_ids(text: str | None) -> tuple[str, ...]:
    """Split `id,id` as typed into ids; None gives none."""
    return tuple(part.strip() for part in (text or "").split(",") if part.strip())


def print_json(content: Any) -> None:
    """Write JSON to standard output; a number that JSON lacks is an error, not `NaN`.

    Signs that standard output cannot encode are escaped, which JSON reads as the signs themselves.
    """
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except UnicodeEncodeError:
        text = json.dumps(content, indent=2, allow_nan=False)
    typer.echo(text)


def conclude(
    result: Writable,
    out: Path,
    command: str,
    *,
    as_json: bool,
    pdf: bool = False,
    advice: str | None = None,
    doubts: Sequence[str] = (),
) -> None:
    """Write the outcome, say doubts, verdict and where things are; end with 4 if not converged.

    Parameters
    ----------
    result : Writable
        The outcome.
    out : Path
        The folder to write to.
    command : str
        The command as typed, for the provenance in the report.
    as_json : bool
        Write the JSON document to standard output instead of words.
    pdf : bool
        Write the report as PDF, too.
    advice : str or None
        What to try next, after the words.
    doubts : sequence of str
        What in the records deserves a second look, for standard error.

    Raises
    ------
    typer.Exit
        With code 4, when a fit did not converge.
    """
    from hdprog.reporting.words import keyboard_signs

    result.write(out, command)
    written = out / "report.html"
    if pdf:
        from hdprog.reporting.pdf import write_pdf

        written = write_pdf(written)
    for doubt in doubts:
        typer.echo(f"Warning: {keyboard_signs(doubt)}", err=True)
    if as_json:
        print_json(_as_typed(result.document(), command))
    else:
        typer.echo(keyboard_signs(result.sentence))
        typer.echo(f"Report: {written}")
        if advice is not None:
            typer.echo(advice)
    if not result.converged:
        again = "with another --seed; if that does not help, the warnings say what it may be"
        if "--quick" in command:
            again = "without --quick, or with another --seed"
        typer.echo(
            "Not converged: the report names the fits, and what rests on them is provisional. "
            f"Run again {again}.",
            err=True,
        )
        raise typer.Exit(ExitCode.NOT_CONVERGED)


def _as_typed(document: dict[str, Any], command: str) -> dict[str, Any]:
    """Give the document with the command in its provenance, as the file that was written has it."""
    if "provenance" not in document:
        return document
    return {**document, "provenance": {**document["provenance"], "command": command}}


def conclude_fits(
    result: Outcome,
    units: Callable[[ReportSettings], ReportSettings],
    out: Path,
    command: str,
    *,
    as_json: bool,
    pdf: bool,
    advice: str | None = None,
) -> None:
    """Conclude with fits of records: in the units asked for, with the doubts of the records."""
    conclude(
        result.reported(units),
        out,
        command,
        as_json=as_json,
        pdf=pdf,
        advice=advice,
        doubts=result.doubts,
    )
