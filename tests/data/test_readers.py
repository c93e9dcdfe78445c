from __future__ import annotations

import datetime
import gzip
import hashlib
import math
import re
import time
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data import text_stream
from hdprog.data.loop import Loop
from hdprog.data.readers import parse_columns, parse_select, read_loop
from hdprog.data.row_parser import Block, RowParser
from hdprog.errors import BadInputError, UsageError
from tests.data.samples import rows, table, two_sided, write

TORQUE, ANGLE = two_sided()


def assert_is_the_record(loop: Loop) -> None:
    assert loop.torque == pytest.approx(TORQUE, rel=1e-8, abs=1e-8)
    assert loop.angle == pytest.approx(ANGLE, rel=1e-8, abs=1e-12)


READ_RIGHT: dict[str, Callable[[], bytes]] = {
    "plain": lambda: table().encode(),
    "tabs": lambda: table("torque_Nm\tangle_rad", "\t").encode(),
    "bars": lambda: table("torque_Nm|angle_rad", "|").encode(),
    "spaces": lambda: table("torque_Nm  angle_rad", "   ").encode(),
    "semicolons and decimal commas": lambda: table("TORQUE [Nm];ANGLE [rad]", ";")
    .replace(".", ",")
    .encode(),
    "quoted decimal commas": lambda: (
        "torque_Nm,angle_rad\n"
        + "\n".join(
            f'"{t:.9g}","{a:.9g}"'.replace(".", ",").replace('","', "\0").replace("\0", '","')
            for t, a in zip(TORQUE, ANGLE, strict=True)
        )
    ).encode(),
    "everything quoted": lambda: "\n".join(
        ",".join(f'"{cell}"' for cell in line.split(",")) for line in table().splitlines()
    ).encode(),
    "byte-order mark": lambda: table().encode("utf-8-sig"),
    "UTF-16": lambda: table("Torque [N·m],angle [rad]").encode("utf-16"),
    "UTF-32": lambda: table().encode("utf-32"),
    "Latin-1": lambda: table("Torque [N·m],Angle [rad]").encode("latin-1"),
    "Latin-1 in the rows": lambda: b"torque_Nm,angle_rad,oil\n"
    + b"\n".join(f"{row},20 °C".encode("latin-1") for row in rows(TORQUE, ANGLE)),
    "CRLF": lambda: table().replace("\n", "\r\n").encode(),
    "CR": lambda: table().replace("\n", "\r").encode(),
    "comments": lambda: ("# rig 3, é\n#\n" + table().replace("\n", "\n# hm\n", 7)).encode(),
    "blank lines": lambda: ("\n \n" + table() + "\n\n  \n").encode(),
    "empty rows at the end": lambda: (table() + ",\n,\n").encode(),
    "empty rows above the header": lambda: (
        ";;\n; \n" + table("torque_Nm;angle_rad", ";")).encode(),
    "no line end": lambda: table().rstrip("\n").encode(),
    "end-of-file sign": lambda: table().encode() + b"\x1a",
    "end-of-file sign on a line": lambda: table().replace("\n", "\r\n").encode() + b"\x1a\r\n",
    "hint for Excel": lambda: ("sep=;\n" + table("torque_Nm;angle_rad", ";")).encode(),
    "further columns": lambda: ("i,torque_Nm,,angle_rad,note\n" + "\n".join(
        f"{n},{t:.9g},,{a:.9g},ok" for n, (t, a) in enumerate(zip(TORQUE, ANGLE, strict=True))
    )).encode(),
    "gzip": lambda: gzip.compress(table().encode()),
    "line breaks in headers": lambda: table(
        '"Torque\n[Nm]","Torsion angle\n\n[rad]"').replace("\n", "\r\n").encode(),
    "signs between columns in a quoted header": lambda: (
        "torque_Nm,angle_rad,\"speed; 'n', 5\"\" wheel\"\n"
        + "\n".join(f"{row},1" for row in rows(TORQUE, ANGLE))).encode(),
    "spaces before quotation marks": lambda: table('"torque_Nm", "angle_rad"').encode(),
    "inches in a header, and a quotation without end": lambda: (
        'torque_Nm,angle_rad,arm of 5",5" disc,"x\n'
        + "\n".join(f"{row},1,2,3" for row in rows(TORQUE, ANGLE))).encode(),
    "units in brackets behind white space": lambda: (
        "  Torque [Nm]   angle (rad)\n" + "\n".join(rows(TORQUE, ANGLE, sign="  "))).encode(),
    "units of several words behind white space": lambda: table(
        "Torque ( N m )\tangle_rad", "\t").replace("\t", " ").encode(),
    "spaces in cells": lambda: table().replace(",", " , ").encode(),
    "plus signs and exponents": lambda: ("torque_Nm,angle_rad\n" + "\n".join(
        f"{t:+.10e},{a:+.10E}" for t, a in zip(TORQUE, ANGLE, strict=True)
    )).encode(),
}  # fmt: skip


@pytest.mark.parametrize("kind", READ_RIGHT)
def test_clumsy_files_are_read_right(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "loop.csv"
    path.write_bytes(READ_RIGHT[kind]())
    loop = read_loop(path)
    assert_is_the_record(loop)
    assert loop.time is None
    assert loop.warnings == ()
    assert loop.source == "loop.csv"
    assert loop.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    ("header", "torque", "angle"),
    [
        ("torque_kNm,angle_deg", 1e-3, 180 / math.pi),
        ("Torque [in·lbf],Torsion angle [arcmin]", 1 / 0.1129848290276167, 10_800 / math.pi),
        ("Drehmoment (Nm),Verdrehwinkel [°]", 1.0, 180 / math.pi),
        ("output torque / Nm,twist_urad", 1.0, 1e6),
    ],
)
def test_units_become_si(tmp_path: Path, header: str, torque: float, angle: float) -> None:
    text = "\n".join([header, *rows(TORQUE * torque, ANGLE * angle)])
    assert_is_the_record(read_loop(write(tmp_path / "loop.csv", text)))


def with_column(header: str, cells: list[str]) -> str:
    lines = table().splitlines()
    return "\n".join(f"{line},{cell}" for line, cell in zip(lines, [header, *cells], strict=True))


def test_rows_below_a_header_of_several_lines_are_named(tmp_path: Path) -> None:
    text = "# rig\n" + table('"Torque\n[Nm]","Angle\n[rad]"') + "1,x\n"
    with pytest.raises(BadInputError, match=rf"row {TORQUE.size + 5}, column 'Angle \[rad\]'"):
        read_loop(write(tmp_path / "a.csv", text))


def test_optional_columns(tmp_path: Path) -> None:
    count = TORQUE.size
    text = with_column(
        "time [ms],T_oil,temperature_F,output_angle_deg",
        [f"{5000 + 10 * n},x,{77 + n / 1000},{n / 10}" for n in range(count)],
    )
    loop = read_loop(write(tmp_path / "loop.csv", text))
    assert loop.time is not None
    assert loop.temperature is not None
    assert loop.output_angle is not None
    assert loop.time == pytest.approx(0.01 * np.arange(count))
    assert loop.temperature[0] == pytest.approx(25.0)
    assert loop.output_angle[10] == pytest.approx(math.radians(1.0))


@pytest.mark.parametrize("header", ["time", "timestamp", "time [ISO 8601]", "time_s"])
@pytest.mark.parametrize("quote", ["", '"'])  # the fast and the careful way of reading
def test_iso_times_need_no_unit(tmp_path: Path, header: str, quote: str) -> None:
    stamps = [
        f"{quote}2025-03-09T14:{n // 60 % 60:02d}:{n % 60:02d}.250+01:00{quote}"
        for n in range(TORQUE.size)
    ]
    loop = read_loop(write(tmp_path / "loop.csv", with_column(header, stamps)))
    assert loop.time == pytest.approx(np.arange(TORQUE.size))


def test_times_since_1970_keep_their_resolution(tmp_path: Path) -> None:
    stamps = [f"{1_700_000_000 + 0.001 * n:.3f}" for n in range(TORQUE.size)]
    loop = read_loop(write(tmp_path / "loop.csv", with_column("time_s", stamps)))
    assert loop.time == pytest.approx(0.001 * np.arange(TORQUE.size), abs=1e-6)


def test_repeated_times_are_dropped_and_said(tmp_path: Path) -> None:
    stamps = [str(n // 2) for n in range(TORQUE.size)]
    loop = read_loop(write(tmp_path / "loop.csv", with_column("time_s", stamps)))
    assert loop.time is None
    assert any("repeat" in warning for warning in loop.warnings)


LOG = "TIME,POSITION,TORQUE,TORQUE_IN,run\n"


def log_file(path: Path) -> Path:
    lines = [f"{n},{a / (2 * math.pi):.12g},{t:.9g},0,100" for n, (t, a) in enumerate(
        zip(TORQUE, ANGLE, strict=True)
    )]  # fmt: skip
    junk = [f"{n},n/a,nan,0,{n % 3}" for n in range(50)]
    return write(path, LOG + "\n".join(junk[:20] + lines + junk[20:]) + "\n")


@pytest.mark.parametrize(
    "select",
    ["run=100", "run=100.0,7", {"run": ("100",)}, {"run": "100"}, {"run": 100}, {"run": [100, 7]}],
)
def test_columns_and_selection(tmp_path: Path, select: Any) -> None:
    path = log_file(tmp_path / "log.csv")
    loop = read_loop(path, columns="torque=TORQUE:Nm,angle=POSITION:rev,time=time:s", select=select)
    assert_is_the_record(loop)
    assert loop.time == pytest.approx(np.arange(TORQUE.size))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"columns": {"torqe": "TORQUE:Nm"}}, r"columns: found 'torqe': .*roles torque, angle"),
        ({"columns": ["torque", "angle"]}, "columns: found an object of type list"),
        ({"columns": {"torque": 3}}, "columns: found 'torque': 3"),
        ({"select": ["run", "100"]}, "select: found an object of type list"),
        ({"drive": "drive.toml"}, r"drive: found 'drive.toml'.*hdprog\.read_drive"),
        ({"drive": {"id": "x"}}, r"drive: found an object of type dict.*hdprog\.read_drive"),
        ({"path": np.zeros((30, 2))}, r"path: found an object of type ndarray.*hdprog\.Loop"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path: Path, given: dict[str, Any], words: str) -> None:
    """A role with a slip in its name had been passed over, and the column guessed."""
    with pytest.raises(UsageError, match=words):
        read_loop(**{"path": write(tmp_path / "loop.csv", table()), **given})


def test_columns_and_selection_of_the_drive(tmp_path: Path) -> None:
    drive = Drive(
        columns={"torque": "TORQUE:Nm", "angle": "POSITION:rev", "time": ""},
        select={"run": ("100",)},
    )
    path = log_file(tmp_path / "log.csv")
    assert_is_the_record(read_loop(path, drive=drive))
    assert read_loop(path, drive=drive).time is None
    with pytest.raises(BadInputError, match="no row with run = 5"):
        read_loop(path, drive=drive, select="run=5")


@pytest.mark.parametrize("speed", ["0.5", "0,5", "0,50"])
def test_numbers_to_select_by_may_have_decimal_commas(tmp_path: Path, speed: str) -> None:
    lines = [f"{speed};{line}" for line in table(sign=";").splitlines()[1:]]
    text = "\n".join(["v;torque_Nm;angle_rad", *lines, "1,5;0;0"])
    loop = read_loop(write(tmp_path / "loop.csv", text.replace(".", ",")), select="v=0.5")
    assert_is_the_record(loop)


def test_a_selection_of_several_columns_takes_rows_that_fit_all(tmp_path: Path) -> None:
    cells = [f"{n % 2},{'slow' if n < 130 else 'fast'}" for n in range(TORQUE.size)]
    path = write(tmp_path / "loop.csv", with_column("even,mode", cells))
    loop = read_loop(path, select="even=0,mode=slow,fast")
    assert loop.torque == pytest.approx(TORQUE[::2])
    with pytest.raises(BadInputError, match="unloading 56%"):
        read_loop(path, select="even=0,mode=slow")


@pytest.mark.parametrize("sign", [",", "\t", ";"])
@pytest.mark.parametrize("run", ["1", "3"])
def test_a_selection_reads_no_row_cell_by_cell_that_need_not_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sign: str, run: str
) -> None:
    """Blocks that hold no row of it, or none at their beginning, had been read so."""
    lines = [
        sign.join((str(part), f"{t:.9g}", f"{a:.12g}"))
        for part in (1, 2, 3)
        for t, a in zip(TORQUE, ANGLE, strict=True)
    ]
    header = sign.join(("run", "torque_Nm", "angle_rad"))
    path = write(tmp_path / "loop.csv", "\n".join([header, *lines]) + "\n")
    monkeypatch.setattr(text_stream, "_BLOCK_BYTES", 1000)
    counted: list[int] = []
    parse = RowParser.parse

    def counting(parser: RowParser, lines: Iterable[tuple[int, list[str]]]) -> Block:
        lines = list(lines)
        counted.append(len(lines))
        return parse(parser, lines)

    monkeypatch.setattr(RowParser, "parse", counting)
    assert_is_the_record(read_loop(path, select=f"run={run}"))
    assert max(counted) == 1


def test_options_taken_apart() -> None:
    assert parse_columns("torque=A, b:Nm, angle=P:rev,time=") == {
        "torque": "A, b:Nm",
        "angle": "P:rev",
        "time": "",
    }
    assert parse_select("test_nr=100,101,mode=slow") == {
        "test_nr": ("100", "101"),
        "mode": ("slow",),
    }
    for text in ("torque", "torqe=A:Nm", "torque=", "time=A:s,time=B:s", ""):
        with pytest.raises(UsageError, match="--columns"):
            parse_columns(text)
    for text in ("run", "run=", "=3", "run=1,run=2", ""):
        with pytest.raises(UsageError, match="--select"):
            parse_select(text)


def test_a_million_rows_take_a_few_seconds(tmp_path: Path) -> None:
    header, *lines = table().splitlines()
    path = tmp_path / "long.csv"
    path.write_text(header + "\n" + 2500 * ("\n".join(lines) + "\n"), encoding="utf-8")
    before = time.process_time()
    loop = read_loop(path)
    assert time.process_time() - before < 10.0
    assert len(loop) == 2500 * TORQUE.size
    assert loop.torque[-TORQUE.size :] == pytest.approx(TORQUE)


def test_excel(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.create_sheet("empty")
    sheet = book.active
    sheet.append(["# rig 3"])
    sheet.append([])
    sheet.append(["Torque [Nm]", "angle_rad", "note"])
    for torque, angle in zip(TORQUE.tolist(), ANGLE.tolist(), strict=True):
        sheet.append([torque, angle])
    path = tmp_path / "loop.xlsx"
    book.save(path)
    loop = read_loop(path)
    assert_is_the_record(loop)
    sheet.insert_rows(4, 2)  # below the header an empty row parts it from the rest, no more
    sheet.append([" ", None])
    book.save(path)
    assert_is_the_record(read_loop(path))
    sheet.insert_rows(60)
    book.save(path)
    with pytest.raises(BadInputError, match=r"row 60: found a row without any value"):
        read_loop(path)
    sheet.delete_rows(60)
    sheet["A50"] = "bad"
    book.save(path)
    with pytest.raises(BadInputError, match=r"row 50, column 'Torque \[Nm\]'.*'bad'"):
        read_loop(path)
    sheet["A50"] = "#DIV/0!"
    book.save(path)
    with pytest.raises(BadInputError, match=r"row 50, column 'Torque \[Nm\]'.*'#DIV/0!'"):
        read_loop(path)
    book["empty"]["A1"] = 1
    book.save(path)
    with pytest.raises(BadInputError, match="several sheets"):
        read_loop(path)


@pytest.mark.parametrize("tail", [",\n,\n", ",\n,", ",", ",\n" * 70_000 + ","])
def test_empty_rows_at_the_end_are_none(tmp_path: Path, tail: str) -> None:
    """With a last line that no line end closes they were refused, "with rows of data after it"."""
    path = tmp_path / "loop.csv"
    path.write_bytes((table() + tail).encode())
    assert_is_the_record(read_loop(path))
    path.write_bytes((table() + tail.removesuffix(",") + ",\n1.0,2e-5\n").encode())
    with pytest.raises(BadInputError, match=r"row 403: found a row without any value"):
        read_loop(path)


def test_a_formula_that_was_not_worked_out_is_no_empty_cell(tmp_path: Path) -> None:
    """Whoever saw numbers in the sheet was told to fill an empty cell in."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["torque_Nm", "angle_rad"])
    for torque, angle in zip(TORQUE.tolist(), ANGLE.tolist(), strict=True):
        book.active.append([torque, f"={angle}*1"])
    path = tmp_path / "loop.xlsx"
    book.save(path)
    with pytest.raises(BadInputError, match=r"cell B2: found the formula '=.*save it there"):
        read_loop(path)


@pytest.mark.parametrize("as_text", [True, False])
def test_thousands_in_cells_of_text_are_refused(tmp_path: Path, as_text: bool) -> None:
    """The same table as CSV was refused; here 1.206 mNm stood for 1206. A number is a number."""
    openpyxl = pytest.importorskip("openpyxl")
    torque = np.round(TORQUE / 40.0 * 900.0)
    cells: list[float | str] = torque.tolist()
    for index in np.flatnonzero(torque == 900.0):
        cells[index] = "1.206" if as_text else 900.125
    book = openpyxl.Workbook()
    for row in [("torque_mNm", "angle_urad"), *zip(cells, (1e6 * ANGLE).tolist(), strict=True)]:
        book.active.append(row)
    path = tmp_path / "loop.xlsx"
    book.save(path)
    if as_text:
        with pytest.raises(BadInputError, match=r"row 102, column 'torque_mNm': found '1\.206'"):
            read_loop(path)
        return
    assert read_loop(path).torque.max() == pytest.approx(0.900125)


@pytest.mark.parametrize("size", [b"A1", b"A1:B320"])
def test_a_sheet_is_read_past_the_size_that_its_file_states(tmp_path: Path, size: bytes) -> None:
    # As some loggers write it, before the rows are there. 319 rows would still make a loop.
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["torque_Nm", "angle_rad"])
    for row in zip(TORQUE.tolist(), ANGLE.tolist(), strict=True):
        book.active.append(row)
    book.save(tmp_path / "whole.xlsx")
    path = tmp_path / "loop.xlsx"
    with zipfile.ZipFile(tmp_path / "whole.xlsx") as whole, zipfile.ZipFile(path, "w") as stated:
        for name in whole.namelist():
            part = whole.read(name)
            stated.writestr(name, re.sub(rb'(?<=<dimension ref=")[^"]+', size, part))
    assert_is_the_record(read_loop(path))


def test_excel_without_openpyxl_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "openpyxl", None)
    (tmp_path / "loop.xlsx").write_bytes(b"PK\x03\x04rest")
    with pytest.raises(BadInputError, match=r"-m pip install -c constraints.txt '\.\[excel\]'"):
        read_loop(tmp_path / "loop.xlsx")


@pytest.mark.parametrize("zone", ["Z", "-05:00", "+0100", "+01"])
@pytest.mark.parametrize("first", [True, False])
def test_a_time_zone_stands_in_all_rows_or_in_none(tmp_path: Path, zone: str, first: bool) -> None:
    """Times without one were taken for those of Greenwich: a gap of hours, or none where one is."""
    start = datetime.datetime(2025, 3, 9, 12)
    stamps = [(start + datetime.timedelta(seconds=n)).isoformat() for n in range(TORQUE.size)]
    whole = [stamp + zone for stamp in stamps]
    for cells in (stamps, whole):
        loop = read_loop(write(tmp_path / "loop.csv", with_column("time", cells)))
        assert loop.time == pytest.approx(np.arange(TORQUE.size))
    mixed = [*whole[:200], *stamps[200:]] if first else [*stamps[:200], *whole[200:]]
    with pytest.raises(BadInputError, match=rf"row 202\b.*with{'out' * first} a time zone"):
        read_loop(write(tmp_path / "loop.csv", with_column("time", mixed)))


@pytest.mark.parametrize("year", ["0001", "1601", "9999"])
def test_a_time_of_no_clock_is_refused_in_words(tmp_path: Path, year: str) -> None:
    """It ended as a mistake of the program."""
    stamps = [f"{year}-01-01T00:{n // 60:02d}:{n % 60:02d}" for n in range(TORQUE.size)]
    path = write(tmp_path / "loop.csv", with_column("time", stamps))
    with pytest.raises(BadInputError, match=r"row 2, column 'time': found .* years 1678 to 2261"):
        read_loop(path)


@pytest.mark.parametrize("cell", ["", "NaT", "nan", "now"])
@pytest.mark.parametrize("at", [40, -1])
def test_an_iso_time_that_is_none_is_named(tmp_path: Path, cell: str, at: int) -> None:
    """Empty cells had become a time of two centuries, and "now" hangs on when it is read."""
    torque, angle = two_sided()
    start = datetime.datetime(2025, 3, 9, 12)
    stamps = [(start + datetime.timedelta(seconds=n)).isoformat() for n in range(torque.size)]
    stamps[at] = cell
    lines = [f"{t},{m:.9g},{a:.9g}" for t, m, a in zip(stamps, torque, angle, strict=True)]
    path = write(tmp_path / "loop.csv", "time,torque_Nm,angle_rad\n" + "\n".join(lines) + "\n")
    row = 2 + at % torque.size
    with pytest.raises(BadInputError, match=rf"row {row}\b"):
        read_loop(path)


@pytest.mark.filterwarnings("error::UserWarning")
def test_a_strict_workbook_is_not_said_to_be_empty(tmp_path: Path) -> None:
    """Nor told of in the words of the package that reads workbooks."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["torque_Nm", "angle_rad"])
    book.save(tmp_path / "common.xlsx")
    common, strict = b"http://schemas.openxmlformats.org/", b"http://purl.oclc.org/ooxml/"
    path = tmp_path / "loop.xlsx"
    with zipfile.ZipFile(tmp_path / "common.xlsx") as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            part = source.read(name).replace(
                common + b"spreadsheetml/2006/", strict + b"spreadsheetml/"
            )
            target.writestr(
                name, part.replace(common + b"officeDocument/2006/", strict + b"officeDocument/")
            )
    with pytest.raises(
        BadInputError, match=r"as Strict Open XML has them; .* save the sheet as CSV"
    ):
        read_loop(path)


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_a_damaged_sheet_is_no_workbook(tmp_path: Path, share: float) -> None:
    """Its archive opens; what is in it does not read."""
    openpyxl = pytest.importorskip("openpyxl")
    torque, angle = two_sided()
    book = openpyxl.Workbook()
    for row in [("torque_Nm", "angle_rad"), *zip(torque.tolist(), angle.tolist(), strict=True)]:
        book.active.append(row)
    whole, path = tmp_path / "whole.xlsx", tmp_path / "loop.xlsx"
    book.save(whole)
    with zipfile.ZipFile(whole) as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            cut = int(share * len(content)) if "sheet1" in name else len(content)
            target.writestr(name, content[:cut])
    with pytest.raises(BadInputError, match="no readable Excel workbook"):
        read_loop(path)


def test_a_workbook_with_parts_that_openpyxl_does_not_know_is_refused(tmp_path: Path) -> None:
    """It ended as a mistake of the program."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in [("torque_Nm", "angle_rad"), *zip(TORQUE.tolist(), ANGLE.tolist(), strict=True)]:
        book.active.append(row)
    book.create_chartsheet("chart to come")
    book.save(tmp_path / "loop.xlsx")
    with pytest.raises(BadInputError, match=r"no readable Excel workbook .* save the sheet as CSV"):
        read_loop(tmp_path / "loop.xlsx")


def test_columns_that_are_given_stand_beside_those_declared(tmp_path: Path) -> None:
    torque, angle = two_sided()
    restarts = np.arange(torque.size) % 50
    lines = [f"{m:.9g},{a:.9g},{t}" for m, a, t in zip(torque, angle, restarts, strict=True)]
    path = write(tmp_path / "loop.csv", "M,POS,TIME\n" + "\n".join(lines) + "\n")
    drive = Drive(columns={"torque": "M:Nm", "angle": "POS:rad", "time": "TIME:s"})
    with pytest.raises(BadInputError, match="--columns time="):
        read_loop(path, drive=drive)
    assert read_loop(path, drive=drive, columns="time=").time is None
