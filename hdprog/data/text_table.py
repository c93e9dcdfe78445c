"""Tables as text: the header and its column sign, then blocks of rows, fast where they are clean.

Each block of rows goes to pandas' C parser. Where that stumbles, or where the block's shape is not
plain, `RowParser` reads the same block cell by cell: it decides, and names what is wrong.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from hdprog.data.columns import find_columns, find_selection
from hdprog.data.row_parser import (
    Block,
    Layout,
    RowParser,
    is_comment,
    matches,
    no_data,
)
from hdprog.data.row_refusals import SHEET_ERROR
from hdprog.data.text_stream import decode, line_blocks
from hdprog.errors import BadInputError
from hdprog.units import ISO_8601

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["column_sign", "endless_cell", "read_text_table", "split_line"]

_MOST_ODD_LINES = 10_000
_MOST_HEADER_LINES = 20  # that headers with line breaks in their cells may take
_ZONE = re.compile(r":.*(?:[Zz]|[+-]\d\d(?::?\d\d)?)\s*$")  # behind a time; a day has -09, too
_UNIT_APART = re.compile(r'(?<!\S)([^\s"\[(]+)\s+(\[[^\[\]"]*\]|\([^()"]*\))(?=\s|$)')
_QUOTED = re.compile(r'(?:^|(?<=[\t;|,])) *"(?:[^"]|"")*" *(?=$|[\t;|,])')


def split_line(line: str, sign: str) -> list[str]:
    """Split one line into cells at a column sign; a space stands for any white space."""
    if sign == " ":
        line = " ".join(line.split())
    return next(csv.reader([line], delimiter=sign, skipinitialspace=True), [])


def endless_cell(where: str) -> BadInputError:
    """Return the error for a cell that is longer than Python's csv module takes."""
    return BadInputError(
        f"a cell of more than {csv.field_size_limit()} signs",
        where,
        "a table with a number or a short text in each cell",
        "Close a quotation mark that is open there, or leave the long text out.",
    )


def column_sign(header: str) -> str:
    """Return the sign between the columns of a header line; a space where there is none.

    What a cell has within quotation marks is no such sign.
    """
    plain = _QUOTED.sub("", header)
    return next((sign for sign in "\t;|," if sign in plain), " ")


def _in_quotation(line: str) -> bool:
    """Tell whether a line ends within a cell that begins with a quotation mark."""
    rest = _QUOTED.sub("", line)
    return re.search(r'(?:^|[\t;|,]) *"', rest) is not None


def read_text_table(
    path: Path,
    columns: Mapping[str, str] | None = None,
    select: Mapping[str, Sequence[str]] | None = None,
) -> tuple[Layout, Block]:
    """Read the columns of a loop from a text file.

    Parameters
    ----------
    path : Path
        CSV, TSV, or with semicolons, bars or white space between the columns; gzip of it.
    columns, select : mapping or None
        As in `hdprog.data.readers.read_loop`.

    Returns
    -------
    Layout, Block
        What the header says, and the numbers of all rows, in the file's units.

    Raises
    ------
    BadInputError
        No text, no header, a ragged row, a cell that is not a finite number, and what
        `find_columns` refuses.
    """
    reader = _TextTable(path.name, columns, select)
    blocks = [block for text in line_blocks(path) for block in reader.read(text)]
    layout = reader.finished_layout()
    roles = [column.role for column in layout.columns]
    return layout, Block(
        {role: np.concatenate([block.values[role] for block in blocks]) for role in roles},
        np.concatenate([block.rows for block in blocks]),
    )


class _TextTable:
    """Takes blocks of lines in order; knows at which row of the file it is."""

    def __init__(
        self,
        name: str,
        columns: Mapping[str, str] | None,
        select: Mapping[str, Sequence[str]] | None,
    ) -> None:
        self.name = name
        self.columns = columns
        self.select = select
        self.row = 1
        self.sign: str | None = None
        self.header: tuple[int, list[str]] | None = None
        self.parser: RowParser | None = None

    def read(self, text: bytes) -> Iterator[Block]:
        """Yield the numbers of a block of lines; nothing before the first row of data."""
        start = 0
        while self.parser is None and start < len(text):
            end = self._end_of_head_line(text, start)
            # Line breaks in a header's cells are spaces, as far as its name and unit go.
            lines = text[start:end].split(b"\n")
            self.row += len(lines) - 1
            if not self._take_head_line(decode(b" ".join(lines)).strip(" ")):
                self.row += 1
                start = end + 1
        text = text[start:]
        if self.parser is None or not text:
            return
        if not text.isascii():
            text = decode(text).encode()
        if self.sign == " ":
            text = b"".join(b" ".join(line.split()) + b"\n" for line in text.split(b"\n")[:-1])
        block = self._fast(text, self.parser)
        yield block if block is not None else self.parser.parse(self._cells(text))
        self.row += text.count(b"\n")

    def _end_of_head_line(self, text: bytes, start: int) -> int:
        """Find the end of a line before the data; a header's cells may run over several."""
        end = last = text.index(b"\n", start)
        line = decode(text[start:end])
        if self.header is None and _in_quotation(line) and not self._is_comment(line):
            for _ in range(_MOST_HEADER_LINES):
                last = text.find(b"\n", last + 1)
                if last < 0:
                    break
                if not _in_quotation(decode(text[start:last])):
                    return last
        return end

    def finished_layout(self) -> Layout:
        """Return the layout; refuse a file without header or row of data, and thousands."""
        if self.parser is None:
            raise no_data(self.name, None if self.header is None else self.header[0])
        self.parser.refuse_thousands()
        return self.parser.layout

    def _take_head_line(self, line: str) -> bool:
        """Look at a line before the data; tell whether it is the first row of data."""
        # Spreadsheets write an empty row as signs alone; below the header it is one without values.
        blank = not line.strip("\t;|, " if self.header is None else None)
        if blank or self._is_comment(line):
            return False
        if self.header is None:
            if self.sign is None and line.lower().startswith("sep=") and len(line) == 5:
                self.sign = line[4]  # a hint for Excel, which it also writes
                return False
            self.sign = self.sign or column_sign(line)
            if self.sign == " ":  # a unit in brackets behind white space is no column of its own
                line = _UNIT_APART.sub(r'"\1 \2"', line)
            self.header = (self.row, self._split(line, self.row))
            return False
        header_row, headers = self.header
        first = self._split(line, self.row)
        where = f"{self.name}, header in row {header_row}"
        found = find_columns(headers, first, self.columns, where)
        selection = find_selection(headers, self.select, where)
        self.parser = RowParser(Layout(self.name, header_row, tuple(headers), found, selection))
        return True

    def _cells(self, text: bytes) -> Iterator[tuple[int, list[str]]]:
        """Yield row number and cells of each line that is neither blank nor a comment."""
        for row, line in enumerate(text.decode().split("\n")[:-1], start=self.row):
            if line.strip() and not self._is_comment(line, row):
                yield row, self._split(line, row)

    def _split(self, line: str, row: int) -> list[str]:
        """Split a line at the file's column sign."""
        try:
            return split_line(line, self.sign or ",")
        except csv.Error as error:
            raise endless_cell(f"{self.name}, row {row}") from error

    def _is_comment(self, line: str, row: int | None = None) -> bool:
        """Tell whether a line is a comment; above the header any line with # at its front is."""
        line = line.lstrip()
        if self.header is None or not SHEET_ERROR.match(line):
            return line.startswith("#")
        return is_comment(self._split(line, row or self.row), len(self.header[1]))

    def _fast(self, text: bytes, parser: RowParser) -> Block | None:
        """Read a block with pandas; None where `RowParser` has to decide."""
        sign = self.sign or ","
        if b'"' in text:
            return None
        plain = _plain_rows(text, sign.encode(), parser.layout.width, self.row)
        if plain is None:
            return None
        text, rows = plain
        if rows.size == 0:
            return parser.parse(())
        if parser.empty_row is not None:
            return None  # what follows may be empty, too
        if parser.decimal is None and b"." in text and sign == ",":
            parser.decimal = "."
        # The first line shows the decimal sign more often than not.
        first_line = self._split(text.partition(b"\n")[0].decode(), int(rows[0]))
        parser.parse([(int(rows[0]), first_line)])
        if parser.decimal is None and b"," in text and sign != ",":
            return None
        return _parse(text, sign, parser, rows)


def _plain_rows(
    text: bytes, sign: bytes, width: int, first_row: int
) -> tuple[bytes, NDArray[np.int64]] | None:
    """Return the lines of data and the row of each; None where one has another number of cells."""
    characters = np.frombuffer(text, dtype=np.uint8)
    ends = np.flatnonzero(characters == ord("\n"))
    signs = np.flatnonzero(characters == sign[0])
    before = np.searchsorted(signs, ends)
    starts = np.concatenate(([0], ends[:-1] + 1))
    odd = (np.diff(before, prepend=0) != width - 1) | (characters[starts] == ord("#"))
    rows = np.arange(first_row, first_row + ends.size, dtype=np.int64)
    if not odd.any():
        return text, rows
    odd_lines = np.flatnonzero(odd)
    if odd_lines.size > _MOST_ODD_LINES:
        return None
    for number in odd_lines:
        line = text[starts[number] : ends[number]].strip()
        if line and (not line.startswith(b"#") or SHEET_ERROR.match(line.decode())):
            return None
    dropped = set(odd_lines.tolist())
    lines = [line for number, line in enumerate(text.split(b"\n")) if number not in dropped]
    return b"\n".join(lines), rows[~odd]


def _parse(text: bytes, sign: str, parser: RowParser, rows: NDArray[np.int64]) -> Block | None:
    """Read plain rows with pandas; None where a cell is not what it should be."""
    import pandas as pd

    layout = parser.layout
    kinds: dict[int, Literal["category", "str", "float64"]] = {
        column.index: "str" if column.unit is ISO_8601 else "float64" for column in layout.columns
    }
    for index, _ in layout.selection:
        if index in kinds:  # both read and selected by
            return None
        kinds[index] = "category"
    try:
        frame = pd.read_csv(
            io.BytesIO(text),
            sep=sign,
            header=None,
            names=list(range(layout.width)),
            usecols=sorted(kinds),
            dtype=kinds,
            decimal=parser.decimal or ".",
            na_filter=False,
            index_col=False,
            engine="c",
            low_memory=False,
            quoting=csv.QUOTE_NONE,
        )
        for index, wanted in layout.selection:
            marks = frame[index].cat
            frame = frame[marks.codes.isin(_codes(marks.categories, wanted))]
        if parser.decimal is None and len(frame) and b"." in text:
            lines = text.split(b"\n")
            number = next((at for at in frame.index if b"." in lines[at]), int(frame.index[0]))
            parser.parse([(int(rows[number]), split_line(lines[number].decode(), sign))])
            if parser.decimal is None:
                return None
        values: dict[str, NDArray[np.generic]] = {}
        for column in layout.columns:
            cells = frame[column.index]
            if column.unit is ISO_8601:
                # Empty cells become no time, and "now" the present: cell by cell each is named.
                if not cells.str.match(r"\s*\d{4}").fillna(False).all():
                    return None
                if (cells.str.contains(_ZONE) != parser.zoned).any():
                    return None
                stamps = pd.to_datetime(cells, format="ISO8601", utc=True)
                values[column.role] = stamps.dt.as_unit("ns").astype("int64").to_numpy()
                continue
            numbers = cells.to_numpy()
            # pandas takes a column of True and False for ones and zeros.
            flags = numbers.size > 0 and np.isin(numbers, (0.0, 1.0)).all()
            if flags or not np.isfinite(numbers).all():
                return None
            values[column.role] = numbers
    except (ValueError, OverflowError):  # pandas' parser errors are ValueErrors
        return None
    _note_separators(text, sign, parser, rows, frame)
    return Block(values, rows[frame.index.to_numpy()])


def _note_separators(
    text: bytes, sign: str, parser: RowParser, rows: NDArray[np.int64], frame: pd.DataFrame
) -> None:
    """Look at commas or points of plain rows as `RowParser` does, in columns still in doubt."""
    open_columns = [index for index, found in parser.separators.items() if not found.decimal]
    kept = frame.index.to_numpy()
    if not open_columns or kept.size == 0:
        return
    sizes = {index: np.abs(frame[index].to_numpy()) for index in open_columns}
    mark = parser.decimal
    if mark is None or mark == sign or mark.encode() not in text:
        for index in open_columns:
            parser.separators[index].note_plain(float(sizes[index].max()))
        return
    characters = np.frombuffer(text, dtype=np.uint8)
    breaks = np.flatnonzero((characters == ord(sign)) | (characters == ord("\n")))
    ends = breaks.reshape(-1, parser.layout.width)
    starts = np.concatenate(([0], breaks[:-1] + 1)).reshape(ends.shape)
    places = np.flatnonzero(characters == ord(mark))
    for index in open_columns:
        found = parser.separators[index]
        start, end = starts[kept, index], ends[kept, index]
        before = np.searchsorted(places, start)
        marked = np.searchsorted(places, end) > before
        found.note_plain(float(sizes[index][~marked].max(initial=-1.0)))
        numbers = np.flatnonzero(marked)
        start, end, place = start[numbers], end[numbers], places[before[numbers]]
        # All but a few cells are settled at a glance; the first stands for those like thousands.
        other = np.flatnonzero(~_like_thousands(characters, start, place, end))
        for number in (*range(min(1, numbers.size)), *other.tolist()):
            cell = text[start[number] : end[number]].decode().strip()
            found.note(cell, int(rows[kept[numbers[number]]]))
            if found.decimal:
                break


def _like_thousands(
    characters: NDArray[np.uint8],
    start: NDArray[np.int64],
    mark: NDArray[np.int64],
    end: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Tell which cells, numbers with one comma or point, are 1 to 999, three digits behind it."""
    first = start + np.isin(characters[start], (ord("+"), ord("-")))
    before = mark - first
    like: NDArray[np.bool_] = (before >= 1) & (before <= 3) & (end - mark == 4)
    like &= (characters[first] >= ord("1")) & (characters[first] <= ord("9"))
    for place in (end - 2, end - 1):  # an exponent, or a space behind, is no such digit
        like &= (characters[place] >= ord("0")) & (characters[place] <= ord("9"))
    return like


def _codes(categories: Iterable[str], wanted: frozenset[str]) -> list[int]:
    """Return the numbers of the categories that are wanted."""
    return [number for number, cell in enumerate(categories) if matches(str(cell), wanted)]
