"""The tests of a drive, as tests.csv lists them."""

from __future__ import annotations

import csv
import datetime
import difflib
import itertools
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

from hdprog.data.numbers import is_number, may_hold_thousands
from hdprog.data.row_parser import is_comment
from hdprog.data.text_stream import decode, line_blocks, require_file
from hdprog.data.text_table import column_sign, endless_cell, split_line
from hdprog.errors import BadInputError

__all__ = ["EVENTS", "RANGES", "DriveTest", "read_tests"]

EVENTS = ("regreased", "reassembled", "replaced")
"""What may have happened to a drive before a test; the trend treats each as a break."""

RANGES = {
    "service_hours": (0.0, 1e7),
    "temperature_C": (-100.0, 200.0),
    "mean_torque_Nm": (0.0, 1e6),
    "mean_speed_rpm": (0.0, 1e6),
}
"""What a number of a test may be: what no drive can have is a slip of the keyboard."""

_REQUIRED = ("test_id", "file", "service_hours")
_KNOWN = (
    *_REQUIRED,
    "date",
    "temperature_C",
    "note",
    "event",
    "mean_torque_Nm",
    "mean_speed_rpm",
)
_FOLDED = {name.casefold(): name for name in _KNOWN}


@dataclass(frozen=True)
class DriveTest:
    """One test of a drive, in the order of tests.csv's columns.

    Parameters
    ----------
    test_id : str
        Unique in the folder, fit for a file's name.
    path : Path
        The loop file.
    service_hours : float
        Hours in service when the test was made.
    date : datetime.date or None
        The day of the test.
    temperature_C : float or None
        Temperature of the drive.
    note : str or None
        Anything.
    event : str or None
        One of `EVENTS`: what was done to the drive since the test before.
    mean_torque_Nm, mean_speed_rpm : float or None
        Load since the test before.
    row : int
        Of tests.csv, from 1; 0 where the test comes from no such table.
    """

    test_id: str
    path: Path
    service_hours: float
    date: datetime.date | None = None
    temperature_C: float | None = None
    note: str | None = None
    event: str | None = None
    mean_torque_Nm: float | None = None
    mean_speed_rpm: float | None = None
    row: int = 0


def read_tests(folder: Path) -> tuple[tuple[DriveTest, ...], tuple[BadInputError, ...]]:
    """Read tests.csv of a drive folder, row by row, past the rows that are wrong.

    Parameters
    ----------
    folder : Path
        The drive folder.

    Returns
    -------
    tests : tuple of DriveTest
        The sound rows, by service hours; of the same hours by date, else as they stand.
    problems : tuple of BadInputError
        One for each row that is wrong.

    Raises
    ------
    BadInputError
        No readable tests.csv, a header that lacks a column, or no test at all.
    """
    path = folder / "tests.csv"
    if not path.exists():
        raise BadInputError(
            "no tests.csv",
            str(folder),
            "a table of the drive's tests with the columns " + ",".join(_REQUIRED),
            "Write one with a row for each loop file, such as t01,loops/t01.csv,0.",
        )
    require_file(path)
    sign, rows = _rows(path)
    if not rows:
        raise _error(path, None, "nothing in it", "a header and one row a test", "Fill it in.")
    header_row, header = rows[0]
    _check_header(path, header_row, header)
    tests: dict[int, DriveTest] = {}
    written: dict[int, str] = {}
    problems: list[BadInputError] = []
    for row, cells in rows[1:]:
        try:
            test = _test(path, row, header, cells)
            if any(other.test_id == test.test_id for other in tests.values()):
                raise _error(
                    path,
                    row,
                    f"test_id '{test.test_id}' a second time",
                    "each test_id once",
                    "Give the test a name of its own.",
                )
            tests[row] = test
            written[row] = cells[header.index("service_hours")]
        except BadInputError as error:
            problems.append(error)
    if not tests and not problems:
        raise _error(
            path, header_row, "a header and no test below it", "one row a test", "Add the tests."
        )
    problems += _both_signs(path, sign, header, rows[1:]) or _thousands(path, tests, written)
    problems += _begun_again(path, tests)
    return _in_order(tests.values()), tuple(problems)


def _in_order(tests: Iterable[DriveTest]) -> tuple[DriveTest, ...]:
    """Tests by service hours; those of the same hours by date where all have one, else by row."""
    found: list[DriveTest] = []
    by_hours = sorted(tests, key=lambda test: test.service_hours)
    for _, group in itertools.groupby(by_hours, key=lambda test: test.service_hours):
        same = list(group)
        dates = {test.test_id: test.date for test in same if test.date is not None}
        if len(dates) == len(same):
            same.sort(key=lambda test: dates[test.test_id])
        found += same
    return tuple(found)


def _both_signs(
    path: Path, sign: str, header: Sequence[str], rows: Iterable[tuple[int, Sequence[str]]]
) -> list[BadInputError]:
    """What is wrong where decimal signs are commas: a German 1.234 is 1234.

    They are where a number has one, and may be where semicolons part columns, unless a point in
    some number can only be a decimal sign.
    """
    numbers = [
        (row, name, cell)
        for row, cells in rows
        for name, cell in zip(header, cells, strict=False)
        if name in RANGES and is_number(cell.replace(",", "."))
    ]
    pointed = [cell for _, _, cell in numbers if "." in cell]
    commas = any("," in cell for _, _, cell in numbers)
    if not commas and (sign != ";" or not all(map(may_hold_thousands, pointed))):
        return []
    why = "decimal signs of this table are commas" if commas else "semicolons part the columns"
    return [
        _error(
            path,
            row,
            f"{name} = '{cell}', whose point seems to part thousands: {why}",
            f"{cell.replace('.', '')} for the one, {cell.replace('.', ',')}0 for the other",
            "Write numbers without thousands separators.",
        )
        for row, name, cell in numbers
        if "." in cell and may_hold_thousands(cell)
    ]


def _thousands(
    path: Path, tests: Mapping[int, DriveTest], written: Mapping[int, str]
) -> list[BadInputError]:
    """What is wrong where points part thousands: 750, 1.250 goes back, 750, 1250 does not."""
    parted = [row for row, cell in written.items() if may_hold_thousands(cell)]
    read = {row: test.service_hours for row, test in tests.items()}
    joined = read | {row: float(written[row].replace(".", "")) for row in parted}
    if _rises(read) or not _rises(joined):
        return []
    cell = written[parted[0]]
    return [
        _error(
            path,
            parted[0],
            f"service_hours = '{cell}', whose point seems to part thousands: as a decimal point it "
            "makes the hours go back from row to row",
            f"{cell.replace('.', '')} for the one, {cell}0 for the other",
            "Write hours without thousands separators.",
        )
    ]


def _rises(hours: Mapping[int, float]) -> bool:
    return list(hours.values()) == sorted(hours.values())


def _begun_again(path: Path, tests: Mapping[int, DriveTest]) -> list[BadInputError]:
    """What is wrong where a new drive's hours begin anew: by its hours it comes before the old."""
    problems = []
    rows = list(tests)
    for number, (row, new) in enumerate(tests.items()):
        if new.event != "replaced":
            continue
        old = _tests_before(new, [tests[other] for other in rows[:number]], tests.values())
        most = max(old, key=lambda test: test.service_hours, default=new)
        if most.service_hours > new.service_hours:
            problems.append(
                _error(
                    path,
                    row,
                    f"service_hours = {new.service_hours:g} of a new drive (event replaced), less "
                    f"than the {most.service_hours:g} of test {most.test_id} before it",
                    "hours that go on counting when the drive is replaced, as tests are taken in "
                    "their order",
                    "Add the old drive's last hours to those of the new one, or give the new one "
                    "a folder of its own; where a date is wrong, correct it.",
                )
            )
    return problems


def _tests_before(
    new: DriveTest, above: Sequence[DriveTest], every: Iterable[DriveTest]
) -> list[DriveTest]:
    """Tests before a new drive's first: by date; of its own day, and without dates, by row.

    The rows above count where they are in order themselves, and more than one tells so.
    """
    day = new.date
    before = [test for test in every if day and test.date is not None and test.date < day]
    days = [test.date for test in above if test.date is not None]
    if day is not None and days:
        in_order = days == sorted(days) and days[0] < day
        return before + [test for test in above if in_order and test.date == day]
    hours = [test.service_hours for test in above]
    return before + (list(above) if len(hours) > 1 and hours == sorted(hours) else [])


def _rows(path: Path) -> tuple[str, list[tuple[int, list[str]]]]:
    """Return the column sign, and number and cells of each row neither blank nor a comment."""
    lines = decode(b"".join(line_blocks(path))).split("\n")
    # Excel's hint at its own sign between columns, which the header shows as well.
    if re.fullmatch(r"sep=.", lines[0].strip(), re.IGNORECASE):
        lines[0] = ""
    header = next((line for line in lines if line.strip() and not line.startswith("#")), ",")
    sign = column_sign(header)
    reader = csv.reader((line + "\n" for line in lines), delimiter=sign)
    rows: list[tuple[int, list[str]]] = []
    last = 0
    try:
        for cells in reader:
            first, last = last + 1, reader.line_num
            if rows:
                for row in range(first + 1, last + 1):
                    if _is_test(path, rows[0][1], split_line(lines[row - 1], sign)):
                        raise _swallowed(path, first, row)
            texts = [cell.strip() for cell in cells]
            if any(texts) and not is_comment(texts, len(rows[0][1]) if rows else 0):
                rows.append((last, texts))
    except csv.Error as error:
        raise endless_cell(f"{path}, row {last + 1}") from error
    return sign, rows


def _is_test(path: Path, header: Sequence[str], cells: Sequence[str]) -> bool:
    """Tell whether a line, such as one of several in a note, is a test: its file is there."""
    texts = dict(zip(header, (cell.strip() for cell in cells), strict=False))
    file, hours = texts.get("file", ""), texts.get("service_hours", "").replace(",", ".")
    try:
        return bool(file) and is_number(hours) and _place_of(path, file).is_file()
    except (OSError, ValueError):  # a path that no file can have
        return False


def _swallowed(path: Path, first: int, row: int) -> BadInputError:
    return _error(
        path,
        first,
        f"a quotation mark that begins a cell and is not closed: row {row}, a test, would be a "
        "part of that cell",
        "every cell that begins with a quotation mark to end with one",
        "Close the quotation, or remove the mark. A mark inside a quotation is written twice.",
    )


def _place_of(path: Path, text: str) -> Path:
    """Return where a loop file lies; either slash parts folders."""
    return path.parent / PureWindowsPath(text).as_posix()


def _check_header(path: Path, row: int, header: list[str]) -> None:
    for name in header:
        near = difflib.get_close_matches(name.casefold(), _FOLDED, n=1, cutoff=0.75)
        if name and header.count(name) > 1:
            raise _error(path, row, f"the column {name} twice", "each column once", "Remove one.")
        # Beside the column itself another name, like max_torque_Nm, is no slip for it.
        beside = near and _FOLDED[near[0]] in header and name.casefold() not in _FOLDED
        if near and name not in _KNOWN and (not beside or near[0] == "event"):
            raise _error(
                path,
                row,
                f"the column '{name}'",
                "other names",
                f"Did you mean {_FOLDED[near[0]]}?",
            )
    for name in _REQUIRED:
        if name not in header:
            raise _error(
                path,
                row,
                f"no column {name} among {', '.join(header)}",
                "at least " + ", ".join(_REQUIRED),
                f"Add the column {name}, separated by commas.",
            )


def _test(path: Path, row: int, header: list[str], cells: list[str]) -> DriveTest:
    if len(cells) > len(header) and not any(cells[len(header) :]):
        cells = cells[: len(header)]
    if len(cells) != len(header):
        raise _error(
            path,
            row,
            f"{len(cells)} cells",
            f"{len(header)}, as many as the header has",
            "Correct the row; a comma inside a note needs quotation marks around the note.",
        )
    texts = dict(zip(header, cells, strict=True))
    _refuse_hidden_event(path, row, texts)
    hours = _number(path, row, texts, "service_hours")
    if hours is None:
        raise _error(path, row, "no service_hours", "hours in service", "Fill the cell in.")
    return DriveTest(
        test_id=_test_id(path, row, texts["test_id"]),
        path=_loop_path(path, row, texts["file"]),
        service_hours=hours,
        date=_date(path, row, texts.get("date", "")),
        temperature_C=_number(path, row, texts, "temperature_C"),
        note=texts.get("note") or None,
        event=_event(path, row, texts.get("event", "")),
        mean_torque_Nm=_number(path, row, texts, "mean_torque_Nm"),
        mean_speed_rpm=_number(path, row, texts, "mean_speed_rpm"),
        row=row,
    )


def _test_id(path: Path, row: int, text: str) -> str:
    # Results are stored in files of this name, which has at most 255 bytes with what is added.
    fits = len(text) <= 100 and len(text.encode()) <= 200
    if re.fullmatch(r"[\w+\-][\w+\-. ]*", text) and fits and not text.endswith("."):
        return text
    raise _error(
        path,
        row,
        f"test_id '{text}'" if text else "no test_id",
        "a name of letters, digits, _ - + . or spaces, at most 100 of them; of scripts beyond "
        "Latin, Greek and Cyrillic fewer",
        "Rename the test, for example t01.",
    )


def _loop_path(path: Path, row: int, text: str) -> Path:
    """Return the path of a loop file; it must lie in the drive folder."""
    if not text:
        raise _error(path, row, "no file", "the path of the loop file", "Fill the cell in.")
    folder = path.parent
    windows = PureWindowsPath(text)
    absolute = bool(windows.drive or windows.root)
    found = _place_of(path, text)
    try:
        inside = not absolute and found.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError):  # a path that no file can have
        inside = False
    if not inside:
        wrong = "by an absolute path" if absolute else "which is outside the drive folder"
        raise _error(
            path,
            row,
            f"the file '{text}', {wrong}",
            "a path inside the drive folder, such as loops/t01.csv",
            "Correct the path; copy the file into the drive folder where it lies elsewhere.",
        )
    if not found.is_file():
        raise _error(
            path,
            row,
            f"the file '{text}', which {'is a folder' if found.is_dir() else 'does not exist'}",
            "the path of a loop file, seen from the drive folder",
            "Correct the path, or copy the file there.",
        )
    return found


def _date(path: Path, row: int, text: str) -> datetime.date | None:
    if not text:
        return None
    try:
        return datetime.datetime.fromisoformat(text).date()
    except ValueError:
        raise _error(
            path,
            row,
            f"the date '{text}'",
            "a date in ISO 8601, like 2025-03-09",
            "Write year, month and day in this order.",
        ) from None


def _event(path: Path, row: int, text: str) -> str | None:
    if not text or text.casefold() in EVENTS:
        return text.casefold() or None
    raise _error(
        path,
        row,
        f"the event '{text}'",
        "nothing, or one of " + ", ".join(EVENTS),
        "Correct the cell; anything else belongs into the note.",
    )


def _refuse_hidden_event(path: Path, row: int, texts: Mapping[str, str]) -> None:
    """Refuse an event in a column that is not read: the trend would run on over its break."""
    if "event" in texts:
        return
    for name, text in texts.items():
        if name not in _KNOWN and text.casefold() in EVENTS:
            raise _error(
                path,
                row,
                f"'{text}' in the column '{name}', which is not read",
                "events in a column called event",
                "Rename the column to event.",
            )


def _number(path: Path, row: int, texts: Mapping[str, str], name: str) -> float | None:
    text = texts.get(name, "")
    if not text:
        return None
    if "," in text and may_hold_thousands(text):
        without = text.replace(",", "")
        raise _error(
            path,
            row,
            f"{name} = '{text}', whose comma may part thousands or be a decimal sign",
            f"a number without a comma, like {without} or {without}.0",
            "Write it without thousands separators, and with a point as the decimal sign.",
        )
    plain = text.replace(",", ".")
    value = float(plain) if is_number(plain) else math.nan
    least, most = RANGES[name]
    if not least <= value <= most:
        raise _error(
            path,
            row,
            f"{name} = '{text}'",
            f"a number from {least:g} to {most:.0f}",
            "Correct the cell." + (" Unknown values stay empty." if name not in _REQUIRED else ""),
        )
    return value


def _error(path: Path, row: int | None, found: str, expected: str, advice: str) -> BadInputError:
    where = str(path) if row is None else f"{path}, row {row}"
    return BadInputError(found, where, expected, advice)
