"""Rows of cells to numbers, one at a time: what decides, and names the cell that is wrong."""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hdprog.data.columns import Column
from hdprog.data.numbers import is_number, may_hold_thousands
from hdprog.data.row_refusals import SHEET_ERROR, bad_cell, ragged
from hdprog.errors import BadInputError
from hdprog.units import ISO_8601

__all__ = [
    "Block",
    "Layout",
    "RowParser",
    "Separators",
    "is_comment",
    "matches",
    "no_data",
]

_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)
_YEARS = range(1678, 2262)  # whole ones that 64 bits of nanoseconds hold
_MICROSECOND = datetime.timedelta(microseconds=1)


@dataclass(frozen=True)
class Layout:
    """What a table's header says, and where that is.

    Parameters
    ----------
    file : str
        The file's name, for messages.
    header_row : int
        Row of the header, from 1.
    headers : tuple of str
        The header cells.
    columns : tuple of Column
        The columns to read.
    selection : tuple of (int, frozenset of str)
        Places of columns, with the values of the rows to keep.
    """

    file: str
    header_row: int
    headers: tuple[str, ...]
    columns: tuple[Column, ...]
    selection: tuple[tuple[int, frozenset[str]], ...] = ()

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.headers)

    @property
    def unread(self) -> tuple[str, ...]:
        """Headers of the columns that nothing is read from."""
        read = {column.index for column in self.columns} | {place for place, _ in self.selection}
        return tuple(
            header.strip()
            for place, header in enumerate(self.headers)
            if header.strip() and place not in read
        )


@dataclass(frozen=True)
class Block:
    """Some rows as numbers: role → values in the unit of the file, and each sample's row.

    Times in ISO 8601 are whole nanoseconds since 1970.
    """

    values: dict[str, NDArray[np.generic]]
    rows: NDArray[np.int64]


def matches(cell: str, wanted: frozenset[str]) -> bool:
    """Tell whether a cell holds one of the values, as text or as a number."""
    cell = cell.strip()
    if cell in wanted:
        return True
    # A comma is a decimal sign where it cannot part thousands.
    plain = cell if may_hold_thousands(cell) else cell.replace(",", ".")
    if not is_number(plain):
        return False
    return any(is_number(value) and float(value) == float(plain) for value in wanted)


def is_comment(cells: Sequence[str], width: int) -> bool:
    """Tell whether a row is a comment: it begins with #, and with no failed cell of a full row.

    A line of ### and words is one, too: beside a cell of it stand numbers, or nothing else.
    """
    first, *others = (cell.strip() for cell in cells) if cells else ("",)
    if len(cells) != width or not SHEET_ERROR.fullmatch(first):
        return first.startswith("#")
    if not first.startswith("###"):
        return False
    filled = [cell for cell in others if cell]
    if any(is_number(cell.replace(",", ".")) for cell in filled):
        return False
    return not filled or not all(cell.startswith("###") for cell in filled)


def no_data(file: str, header_row: int | None) -> BadInputError:
    """Return the error for a table that ends before its first row of data."""
    return BadInputError(
        "nothing in it" if header_row is None else "no row of data below the header",
        file if header_row is None else f"{file}, after row {header_row}",
        "a header and one row a sample",
        "Export the record again: the file is empty, or was cut short.",
    )


@dataclass
class Separators:
    """What the commas, or the points, in the numbers of one column have shown so far.

    Parameters
    ----------
    decimal : bool
        Whether there is one that cannot part thousands.
    largest_plain : float
        Largest size of a number without any, negative where there is none: with fixed decimals
        none would be.
    doubtful : (int, str) or None
        Row and text of the first number whose comma or point may part thousands.
    """

    decimal: bool = False
    largest_plain: float = -1.0
    doubtful: tuple[int, str] | None = None

    def note(self, cell: str, row: int) -> None:
        """Take note of a cell that is a number."""
        if "," not in cell and "." not in cell:
            self.note_plain(abs(float(cell)))
        elif may_hold_thousands(cell):
            self.doubtful = self.doubtful or (row, cell)
        else:
            self.decimal = True

    def note_plain(self, size: float) -> None:
        """Take note of the size of numbers without comma and point."""
        self.largest_plain = max(self.largest_plain, size)

    def in_doubt(self) -> tuple[int, str] | None:
        """Row and text of a number that may be a thousand times larger; None where none is.

        A point is taken for the decimal sign unless only thousands have one: numbers without reach
        100, and none 1000.
        """
        if self.doubtful is None or self.decimal:
            return None
        least, below = (0.0, math.inf) if "," in self.doubtful[1] else (100.0, 1000.0)
        return self.doubtful if least <= self.largest_plain < below else None


@dataclass
class RowParser:
    """Parses rows in the order of the file and remembers what spans more than one of them.

    `decimal` is the decimal sign once it is known, `empty_row` the first row without any value:
    such rows may only stand at the end. `zoned` says whether times in ISO 8601 have a zone, once
    one is read. `separators` says of each column whether its commas or points can be decimal
    signs, which takes the whole file.
    """

    layout: Layout
    decimal: str | None = None
    empty_row: int | None = field(default=None, init=False)
    zoned: bool | None = field(default=None, init=False)
    separators: dict[int, Separators] = field(init=False)

    def __post_init__(self) -> None:
        self.separators = {
            column.index: Separators()
            for column in self.layout.columns
            if column.unit is not ISO_8601
        }

    def parse(self, rows: Iterable[tuple[int, Sequence[str]]]) -> Block:
        """Turn rows, each with its number in the file, into numbers.

        Raises
        ------
        BadInputError
            A ragged row, or a cell that is not a finite number.
        """
        layout = self.layout
        values: dict[str, list[float]] = {column.role: [] for column in layout.columns}
        kept: list[int] = []
        for row, cells in rows:
            if not any(cell.strip() for cell in cells):
                self.empty_row = self.empty_row or row
                continue
            self.refuse_empty_row()
            if len(cells) != layout.width:
                raise ragged(cells, row, layout.file, layout.header_row, layout.width)
            if not all(matches(cells[index], wanted) for index, wanted in layout.selection):
                continue
            kept.append(row)
            for column in layout.columns:
                cell = cells[column.index].strip()
                if column.unit is ISO_8601:
                    values[column.role].append(self._nanoseconds(cell, row, column))
                else:
                    values[column.role].append(self._number(cell, row, column))
        arrays: dict[str, NDArray[np.generic]] = {
            column.role: np.array(
                values[column.role], dtype=np.int64 if column.unit is ISO_8601 else np.float64
            )
            for column in layout.columns
        }
        return Block(arrays, np.array(kept, dtype=np.int64))

    def refuse_empty_row(self) -> None:
        """Refuse an empty row that turns out not to be at the end of the file."""
        if self.empty_row is not None:
            raise BadInputError(
                "a row without any value, with rows of data after it",
                f"{self.layout.file}, row {self.empty_row}",
                "a value in every column that is read",
                "Fill the row in, or remove it.",
            )

    def refuse_thousands(self) -> None:
        """Refuse, once all rows are read, what parts thousands for all one can see."""
        for column in self.layout.columns:
            doubtful = self.separators.get(column.index, Separators()).in_doubt()
            if doubtful is None:
                continue
            row, cell = doubtful
            name, otherwise = ("comma", ", or use a point") if "," in cell else ("point", "")
            raise self._error(
                f"'{cell}', and numbers without a {name} in the same column",
                row,
                column,
                "numbers without thousands separators: "
                f"'{cell}' may be {re.sub('[,.]', '', cell)} or {cell.replace(',', '.')}",
                f"Export the file without them. Where the {name} is the decimal sign, write all "
                f"numbers of the column with as many decimals{otherwise}.",
            )

    def _number(self, cell: str, row: int, column: Column) -> float:
        text = cell
        if "," in cell and self.decimal != "." and "." not in cell:
            self.decimal = ","
            text = cell.replace(",", ".")
        elif "." in cell and self.decimal is None:
            self.decimal = "."
        elif "." in cell and self.decimal == ",":
            raise self._bad(cell, row, column)
        if not is_number(text):
            raise self._bad(cell, row, column)
        value = float(text)
        if not math.isfinite(value):
            raise self._bad(cell, row, column)
        self.separators[column.index].note(cell, row)
        return value

    def _nanoseconds(self, cell: str, row: int, column: Column) -> int:
        try:
            stamp = datetime.datetime.fromisoformat(cell)
        except ValueError:
            raise self._error(
                f"'{cell}'" if cell else "an empty cell",
                row,
                column,
                "a date and time in ISO 8601, like 2025-03-09T14:21:08.5",
                "Correct the cell, or record the time in seconds as time_s.",
            ) from None
        zoned = stamp.tzinfo is not None
        if self.zoned not in (None, zoned):
            raise self._error(
                f"'{cell}' {'with' if zoned else 'without'} a time zone, unlike the times above",
                row,
                column,
                "a time zone in all rows, or in none",
                "Write the same times with it, or without it, everywhere.",
            )
        self.zoned = zoned
        if stamp.year not in _YEARS:
            raise self._error(
                f"'{cell}'",
                row,
                column,
                f"a time in the years {_YEARS[0]} to {_YEARS[-1]}",
                "Correct the cell: a logger whose clock is not set may have written it.",
            )
        if not zoned:
            stamp = stamp.replace(tzinfo=datetime.UTC)
        return (stamp - _EPOCH) // _MICROSECOND * 1000

    def _error(
        self, found: str, row: int, column: Column, expected: str, advice: str
    ) -> BadInputError:
        where = f"{self.layout.file}, row {row}, column '{column.header}'"
        return BadInputError(found, where, expected, advice)

    def _bad(self, cell: str, row: int, column: Column) -> BadInputError:
        first = row == self.layout.header_row + 1
        return bad_cell(cell, row, column, self.layout.file, self.decimal, first=first)
