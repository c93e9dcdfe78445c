"""Words for rows and cells of a table that are no numbers, and what may lie behind them."""

from __future__ import annotations

import re
from collections.abc import Sequence

from hdprog.data.columns import Column
from hdprog.data.numbers import is_number, may_hold_thousands
from hdprog.data.roles import ROLES
from hdprog.errors import BadInputError
from hdprog.units import find_unit

SHEET_ERROR = re.compile(r"#(?:N/A|NV|[A-ZÄÖÜ0/_]+[!?]|##+)")
"""What a spreadsheet writes into a cell whose formula fails (#N/A, #DIV/0!, #WERT!), and, as text,
into one of a column that is too narrow for its number or date (########)."""

_MEASURED = re.compile(r"[+-]?[\d.,]*\d(?:[eE][+-]?\d+)?\s*")  # the number before a unit


def bad_cell(
    cell: str, row: int, column: Column, file: str, decimal: str | None, *, first: bool
) -> BadInputError:
    """Name a cell that is no finite number, and what may lie behind it.

    Parameters
    ----------
    cell, row, column, file : the text, and where it stands
    decimal : sign of the numbers before it, None where it is not known
    first : whether the row is the first below the header
    """
    found, expected = f"the text '{cell[:60]}'", "a number"
    advice = "Correct the cell, or remove the row."
    folded = cell.casefold().lstrip("+-")
    if not cell:
        found = "an empty cell"
        advice = "Fill the cell in, or remove the row."
    elif re.fullmatch("#{3,}", cell):
        found = f"'{cell[:60]}' (of a column of the spreadsheet that is too narrow)"
        advice = "Make the column wider in the spreadsheet, and export the file again."
    elif SHEET_ERROR.fullmatch(cell):
        found = f"'{cell}' (an error of the spreadsheet)"
        advice = "Mend the formula behind the cell, or remove the row."
    elif folded in {"nan", "na", "n/a", "null", "none"}:
        found, expected = f"'{cell}' (no value)", "a finite number"
    elif folded in {"inf", "infinity"} or is_number(cell.replace(",", ".")):
        found, expected = f"'{cell}'", "a finite number"
        if "," in cell or "." in cell:
            expected = f"a number with the decimal sign '{decimal or '.'}' as before"
            advice = "Write all numbers of the file with the same decimal sign."
            if may_hold_thousands(cell):
                advice = f"Export the file without thousands separators. {advice}"
    elif is_number(re.sub("[dD]", "e", cell.replace(",", "."), count=1)):
        advice = "Export the file with E in exponents, like 1.5E-05, or without exponents."
    elif is_number(re.sub("[\u2212\u2013]", "-", cell.replace(",", "."))):
        expected += " with a plain minus sign"
        advice = "Replace the typographic minus signs of the file by '-'."
    elif _MEASURED.match(cell) and find_unit(_MEASURED.sub("", cell)) is not None:
        expected += " alone"
        advice = "Write the unit into the header, like torque_Nm, and remove it from the rows."
    elif re.fullmatch(r"[+-]?\d{1,3}(?:[.,'\u2019\s]\d{3})+(?:[.,]\d+)?", cell):
        advice = "Export the file without thousands separators."
    elif first and (unit := find_unit(cell.strip("[]()"))) is not None:
        advice = (
            "A row of units is not read: write the units into the header, like torque_Nm, and "
            "remove the row."
        )
        if unit != column.unit:
            expected = f"no other unit than the column's, which is {column.unit.name}"
            advice = (
                "Find out which of the two is right, write it into the header, and remove the row."
            )
    elif column.role == "time" and ":" in cell:
        expected = "a number, as the column's unit says"
        advice = "Record the time in seconds, or as ISO 8601 (2025-03-09T14:21:08.5)."
    if expected in ("a number", "a finite number") and not ROLES[column.role].required:
        advice = f"{advice} A record does without it: --columns {column.role}= leaves it out."
    return BadInputError(found, f"{file}, row {row}, column '{column.header}'", expected, advice)


def ragged(cells: Sequence[str], row: int, file: str, header_row: int, width: int) -> BadInputError:
    """Name a row that has more or fewer cells than the header, and what may lie behind it."""
    advice = "Correct or remove the row; it may be cut short, or hold a column sign too many."
    if len(cells) == width + 1 and not cells[-1].strip():
        advice = (
            "The row ends with a column sign. Where all rows do, end the header with one, too; "
            "else remove it."
        )
    elif len(cells) == 1 and width > 1 and row == header_row + 1:
        advice = (
            "Part the columns of all rows by the sign that parts those of the header. Where "
            "the row is a remark, remove it."
        )
    elif len(cells) == width - 1 and row == header_row + 1:
        advice = (
            "Where all rows have as many, the header names a column that they lack, such as "
            "the Comment of LabVIEW, or ends with a column sign: remove that from the header."
        )
    elif (
        len(cells) == width + 1
        and row == header_row + 1
        and any("." in cell for cell in cells)  # else a decimal comma may part a number
    ):
        advice = (
            "The header may lack the name of the first column, which some programs write for "
            "the numbers of rows alone: name it there, or leave it out (in R, write.table with "
            "row.names = FALSE)."
        )
    elif len(cells) in {2 * width, 2 * width - 1}:
        advice = (
            "If the numbers have decimal commas, export the file with semicolons or tabs "
            "between the columns."
        )
    return BadInputError(
        f"{len(cells)} cell{'' if len(cells) == 1 else 's'}",
        f"{file}, row {row}",
        f"{width}, as many as the header in row {header_row} has",
        advice,
    )
