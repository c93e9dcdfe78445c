"""Reading one loop file: bytes to a record in SI, or to words about what is wrong."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hdprog.config import Drive, require_drive
from hdprog.data.column_options import (
    given_columns,
    given_selection,
    parse_columns,
    parse_select,
)
from hdprog.data.excel_table import read_excel_table
from hdprog.data.loop import Loop
from hdprog.data.quality import assess
from hdprog.data.row_parser import Block, Layout
from hdprog.data.text_stream import file_digest, looks_like_excel, require_file
from hdprog.data.text_table import read_text_table
from hdprog.errors import BadInputError, UsageError
from hdprog.units import ISO_8601

__all__ = ["parse_columns", "parse_select", "read_loop"]


def read_loop(
    path: str | Path,
    *,
    columns: Mapping[str, str] | str | None = None,
    select: Mapping[str, Sequence[str]] | str | None = None,
    drive: Drive | None = None,
) -> Loop:
    """Read a record of torque against torsion angle.

    Parameters
    ----------
    path : str or Path
        CSV, TSV or another text table, gzip of it, or .xlsx.
    columns : mapping, str or None
        Role (torque, angle, time, temperature, output_angle) → ``HEADER:unit`` where the headers
        do not say it, or the same as the text of ``--columns``.
    select : mapping, str or None
        Column → value or values of the rows to keep, or the same as the text of ``--select``.
    drive : Drive or None
        Its columns hold for roles that are not given, its selection where none is; the record is
        compared with it.

    Returns
    -------
    Loop
        In SI, with warnings about what deserves a second look.

    Raises
    ------
    BadInputError
        The file is not a usable record; the message names file, row and column.
    UsageError
        `columns` or `select` makes no sense, `path` is no path, or `drive` no drive.
    """
    _require_path(path)
    drive = require_drive(drive)
    path, columns, select = Path(path), given_columns(columns), given_selection(select)
    if drive is not None:
        columns = {**drive.columns, **(columns or {})}
        select = drive.select if select is None else select
    require_file(path)
    digest = file_digest(path)
    read_table = read_excel_table if looks_like_excel(path) else read_text_table
    layout, block = read_table(path, columns, select)
    if block.rows.size == 0:
        raise _none_selected(layout, select or {})
    channels = {column.role: _in_si(block, column.role, layout) for column in layout.columns}
    _refuse_backwards(channels.get("time"), block, layout)
    loop = Loop(
        torque=channels["torque"],
        angle=channels["angle"],
        time=channels.get("time"),
        temperature=channels.get("temperature"),
        output_angle=channels.get("output_angle"),
        source=path.name,
        sha256=digest,
        unread=layout.unread,
    )
    return loop.with_warnings(assess(loop, drive).warnings)


def _require_path(path: object) -> None:
    if not isinstance(path, str | os.PathLike):
        raise UsageError(
            f"path: found an object of type {type(path).__name__}, expected the path of a loop "
            "file. Make a record of arrays with hdprog.Loop(torque=..., angle=...)."
        )


def _in_si(block: Block, role: str, layout: Layout) -> NDArray[np.float64]:
    unit = next(column.unit for column in layout.columns if column.role == role)
    values = block.values[role]
    if unit is ISO_8601:
        stamps = values.astype(np.int64)
        # The difference of whole nanoseconds is exact; a float of the stamps would not be.
        seconds: NDArray[np.float64] = (stamps - stamps[0]) * 1e-9
        return seconds
    return unit.to_si(values.astype(np.float64))


def _refuse_backwards(time: NDArray[np.float64] | None, block: Block, layout: Layout) -> None:
    """Refuse times that run backwards, with the row that a `Loop` no longer knows."""
    if time is None:
        return
    back = np.flatnonzero(np.diff(time) < 0)
    if back.size == 0:
        return
    header = next(column.header for column in layout.columns if column.role == "time")
    before, after = int(back[0]), int(back[0]) + 1
    raise BadInputError(
        f"a time that is {time[before] - time[after]:.6g} s before that of row "
        f"{block.rows[before]}",
        f"{layout.file}, row {block.rows[after]}, column '{header}'",
        "times that do not run backwards",
        "Put the rows in the order of recording, keep one run of the rig with --select, or leave "
        "the time out with --columns time= where the order of the rows is right.",
    )


def _none_selected(layout: Layout, select: Mapping[str, Sequence[str]]) -> BadInputError:
    wanted = " and ".join(f"{name} = {', '.join(values)}" for name, values in select.items())
    return BadInputError(
        f"no row with {wanted}",
        layout.file,
        "rows with the selected values",
        "Correct --select, or [select] in drive.toml.",
    )
