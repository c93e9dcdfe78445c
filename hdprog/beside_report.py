"""Results of one kind a folder: its report.html belongs to what lies beside it."""

from __future__ import annotations

from pathlib import Path

from hdprog.errors import BadInputError

# What lies beside a report.html tells what was reported, and which commands write the two.
_BESIDE = {
    "posteriors": "`hdprog run` or `explain` of a drive",
    "posterior.nc": "`hdprog fit` or `explain` of a record",
    "compare.json": "`hdprog compare`",
    "backtest.json": "`hdprog backtest`",
    "reproduction.json": "`hdprog reproduce-paper`",
}


_OF_A_DRIVE = ("drive.toml", "tests.csv")


def require_no_drive_files(folder: Path, where: str) -> None:
    """Refuse to write results among the files of a drive, where they pass for records of it.

    Parameters
    ----------
    folder : to write to
    where : the folder as the user gave it, for the message

    Raises
    ------
    BadInputError
        When the folder holds a drive's settings or its list of tests.
    """
    for name in _OF_A_DRIVE:
        if (folder / name).exists():
            raise BadInputError(
                f"the {name} of a drive, among whose own files the results would lie",
                where,
                "a new folder, or one with earlier results",
                "Give another folder with --out DIR.",
            )


def require_no_other_report(folder: Path, beside: str, where: str | None = None) -> None:
    """Refuse to replace a report.html that belongs to results of another kind.

    Parameters
    ----------
    folder : to write to
    beside : what is written beside report.html, one of the names above
    where : the folder as the user gave it, for the message

    Raises
    ------
    BadInputError
        When the folder holds results of another kind, whose report would be lost.
    """
    for other, commands in _BESIDE.items():
        if other != beside and (folder / other).exists():
            raise BadInputError(
                f"the {other} of {commands}, whose report.html would be replaced",
                str(folder) if where is None else where,
                f"a new folder, or one with earlier results of {_BESIDE[beside]}",
                "Give another folder" + ("." if where is None else " with --out DIR."),
            )
