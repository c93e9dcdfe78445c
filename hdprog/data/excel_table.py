"""Tables in Excel workbooks (.xlsx), with openpyxl from the extra `excel`."""

from __future__ import annotations

import datetime
import itertools
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from hdprog.data.columns import find_columns, find_selection
from hdprog.data.numbers import may_hold_thousands
from hdprog.data.row_parser import Block, Layout, RowParser, is_comment, no_data
from hdprog.errors import BadInputError
from hdprog.extras import install_words

if TYPE_CHECKING:
    from openpyxl.workbook import Workbook

__all__ = ["read_excel_table"]

# What a workbook raises that was cut or damaged, when it is opened or where a sheet is read.
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    ElementTree.ParseError,
    EOFError,
    KeyError,
    ValueError,
    OSError,
)

# And where openpyxl does not know what another program wrote: a style, an empty sheet for a chart.
_UNKNOWN_PARTS = (AttributeError, IndexError, TypeError)

_LOOKED_THROUGH = 1000  # rows of a refused sheet: formulas fill a column from its top


def read_excel_table(
    path: Path,
    columns: Mapping[str, str] | None = None,
    select: Mapping[str, Sequence[str]] | None = None,
) -> tuple[Layout, Block]:
    """Read the columns of a loop from the only sheet of a workbook that holds anything.

    Parameters
    ----------
    path : Path
        An .xlsx file.
    columns, select : mapping or None
        As in `hdprog.data.readers.read_loop`.

    Returns
    -------
    Layout, Block
        What the header says, and the numbers of all rows, in the file's units.

    Raises
    ------
    BadInputError
        openpyxl is missing, this is no workbook, more than one sheet holds something, and what is
        refused of a text file.
    """
    with warnings.catch_warnings():
        # Of parts beside the cells, which are not read: styles, forms, links to other files.
        warnings.filterwarnings("ignore", category=UserWarning, module="openpyxl")
        workbook = _open(path)
        try:
            return _read(workbook, path, columns, select)
        except BadInputError:
            with suppress(*_DAMAGED, *_UNKNOWN_PARTS):  # past what was refused: that stands
                if found := _not_worked_out(path):
                    raise found from None
            raise
        except _DAMAGED as error:
            raise _unreadable(path, error) from error
        finally:
            workbook.close()


def _read(
    workbook: Workbook,
    path: Path,
    columns: Mapping[str, str] | None,
    select: Mapping[str, Sequence[str]] | None,
) -> tuple[Layout, Block]:
    if not workbook.worksheets:
        raise BadInputError(
            "a workbook without a sheet that can be read, as Strict Open XML has them",
            path.name,
            "a common Excel workbook (.xlsx)",
            "Save it in Excel as 'Excel Workbook (*.xlsx)', or save the sheet as CSV.",
        )
    for sheet in workbook.worksheets:
        sheet.reset_dimensions()  # rows past a size that the file states too small would be lost
    filled = [sheet for sheet in workbook.worksheets if any(_rows(sheet.values))]
    if len(filled) > 1:
        raise BadInputError(
            "several sheets that hold something: "
            + ", ".join(f"'{sheet.title}'" for sheet in filled),
            path.name,
            "one sheet with the record",
            "Save the sheet with the record as a file of its own, or as CSV.",
        )
    if not filled:
        raise no_data(path.name, None)
    rows = _rows(filled[0].values)
    header_row, headers = next(rows)
    first = next((row for row in rows if row[1]), None)
    if first is None:
        raise no_data(path.name, header_row)
    where = f"{path.name}, header in row {header_row}"
    found = find_columns(headers, first[1], columns, where)
    selection = find_selection(headers, select, where)
    parser = RowParser(Layout(path.name, header_row, tuple(headers), found, selection), ".")
    block = parser.parse(_padded([first], len(headers), rows))
    parser.refuse_thousands()
    return parser.layout, block


def _open(path: Path) -> Workbook:
    try:
        import openpyxl
    except ImportError as error:
        raise BadInputError(
            "an Excel workbook, and no openpyxl to read it with",
            path.name,
            "the package openpyxl to be installed",
            f"Save the sheet as CSV, or install it: {install_words('excel')}",
        ) from error
    from openpyxl.utils.exceptions import InvalidFileException

    try:
        # The file's name need not end in .xlsx; its bytes do not lie.
        return openpyxl.load_workbook(path.open("rb"), read_only=True, data_only=True)
    except (InvalidFileException, *_DAMAGED, *_UNKNOWN_PARTS) as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: Exception) -> BadInputError:
    return BadInputError(
        f"a zip archive that is no readable Excel workbook ({error})",
        path.name,
        "a CSV file, gzip of it, or .xlsx",
        "Unpack the archive first, or save the sheet as CSV.",
    )


def _not_worked_out(path: Path) -> BadInputError | None:
    """Find a formula without a value, whose cell a reader of values takes for an empty one."""
    import openpyxl
    from openpyxl.utils import get_column_letter

    with path.open("rb") as stream:
        formulas = openpyxl.load_workbook(stream, read_only=True)
        values = openpyxl.load_workbook(stream, read_only=True, data_only=True)
        for sheet, shown in zip(formulas.worksheets, values.worksheets, strict=True):
            sheet.reset_dimensions()
            shown.reset_dimensions()
            rows = zip(sheet.values, shown.values, strict=True)
            for row, pair in enumerate(itertools.islice(rows, _LOOKED_THROUGH), start=1):
                for column, (cell, value) in enumerate(zip(*pair, strict=True), start=1):
                    if value is None and isinstance(cell, str) and cell.startswith("="):
                        return BadInputError(
                            f"the formula '{cell[:60]}' without a value, as programs write it that "
                            "do not work it out",
                            f"{path.name}, sheet '{sheet.title}', cell "
                            f"{get_column_letter(column)}{row}",
                            "formulas with their values, or numbers",
                            "Open the workbook in a spreadsheet program and save it there, or save "
                            "the sheet as CSV.",
                        )
    return None


def _rows(values: Iterator[tuple[object, ...]]) -> Iterator[tuple[int, list[str]]]:
    """Yield number and cells of each row from the header on that is no comment."""
    width = 0  # of the header, once it is known
    for row, cells in enumerate(values, start=1):
        texts = [_text(cell) for cell in cells]
        while texts and not texts[-1]:
            texts.pop()
        # A sheet has no short rows: where the last cells are empty, they are there all the same.
        if (texts or width) and not is_comment(texts + [""] * (width - len(texts)), width):
            width = width or len(texts)
            yield row, texts


def _text(cell: object) -> str:
    """Return a cell as it would stand in a CSV file."""
    if cell is None:
        return ""
    if isinstance(cell, datetime.datetime):
        return cell.isoformat()
    if isinstance(cell, float):
        # A point in a cell that is a number is a decimal sign; 1.206 as a text may be 1206.
        text = repr(cell).removesuffix(".0")
        return f"{text}0" if may_hold_thousands(text) else text
    return str(cell).strip()


def _padded(
    start: Sequence[tuple[int, list[str]]], width: int, rows: Iterator[tuple[int, list[str]]]
) -> Iterator[tuple[int, list[str]]]:
    """Yield all rows with empty cells up to the width of the header: a sheet has no short rows."""
    for part in (start, rows):
        for row, cells in part:
            yield row, cells + [""] * (width - len(cells))
