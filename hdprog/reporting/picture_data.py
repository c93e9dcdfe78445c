"""The numbers behind a picture, as a CSV file inside the page."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from urllib.parse import quote

import numpy as np

from hdprog.physics.parameters import FloatArray

MOST_ROWS = 400
"""Rows of one file at most, so that a report of many tests stays small enough to send."""

_DIGITS = 6
_FILE_NAME = re.compile(r"[^\w.-]+")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_PLAIN = " !$()*+,/:;=?@[]^|~"

Cell = str | float | None


@dataclass(frozen=True)
class PictureData:
    """A table of what a picture shows.

    Attributes
    ----------
    file : name of the file that a reader saves
    columns : with their units, such as "torque [Nm]"
    rows : one cell a column; None is left empty
    left_out : rows are evenly chosen out of this many more
    """

    file: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    left_out: int = 0

    @staticmethod
    def of(name: str, columns: Sequence[str], rows: Iterable[Sequence[Cell]]) -> PictureData:
        """Table of rows as they are; `name` becomes the file's."""
        return PictureData(file_name(name), tuple(columns), tuple(tuple(row) for row in rows))

    @staticmethod
    def along(
        name: str, columns: Sequence[str], *values: FloatArray, most: int = MOST_ROWS
    ) -> PictureData:
        """Table of arrays (rows,) side by side, at most so many rows, evenly chosen."""
        size = values[0].size
        chosen = np.unique(np.linspace(0, size - 1, min(size, most)).astype(np.intp))
        rows = zip(*(array[chosen].tolist() for array in values), strict=True)
        return PictureData(
            file_name(name), tuple(columns), tuple(map(tuple, rows)), size - chosen.size
        )

    @property
    def text(self) -> str:
        """The file's content: a head and the rows, six digits a number."""
        buffer = io.StringIO()
        writer = csv.writer(buffer, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([_cell(value) for value in row] for row in self.rows)
        return buffer.getvalue()

    @property
    def uri(self) -> str:
        """The file as a `data:` address."""
        return "data:text/csv;charset=utf-8," + quote(self.text, safe=_PLAIN)


def file_name(name: str) -> str:
    """Name of a CSV file that every system can save."""
    return f"{_FILE_NAME.sub('-', name).strip('-.')[:60] or 'picture'}.csv"


def _cell(value: Cell) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return no_formula(value)
    return f"{value:.{_DIGITS}g}" if math.isfinite(value) else ""


def no_formula(text: str) -> str:
    """A cell's text that no spreadsheet runs as a formula."""
    return f"'{text}" if text.startswith(_FORMULA) else text
