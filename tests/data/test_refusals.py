"""Files that cannot be used: refused with the place, what was found and what to do."""

from __future__ import annotations

import gzip
import io
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hdprog.data.text_stream as text_stream
from hdprog.data.columns import Column
from hdprog.data.readers import read_loop
from hdprog.data.row_parser import Layout, RowParser
from hdprog.data.text_table import _TextTable
from hdprog.errors import BadInputError
from hdprog.units import find_unit
from tests.data.samples import PEAK, ramps, rows, table, twist, two_sided, write

TORQUE, ANGLE = two_sided()
LINES = table().splitlines()


def refused(path: Path, columns: str | None = None) -> str:
    with pytest.raises(BadInputError) as caught:
        read_loop(path, columns=columns)
    return str(caught.value)


def changed(row: int, line: str) -> str:
    return "\n".join([*LINES[: row - 1], line, *LINES[row:]]) + "\n"


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("abc,0.1", ["column 'torque_Nm'", "'abc'"]),
        ("1.0,nan", ["column 'angle_rad'", "'nan'"]),
        ("NaN,1.0", ["'NaN'"]),
        ("inf,1.0", ["'inf'", "finite"]),
        ("1e999,1.0", ["'1e999'", "finite"]),
        (",1.0", ["an empty cell"]),
        (",", ["a row without any value"]),
        ("1.0", ["1 cell", "2, as many"]),
        ("1.0,2.0,3.0", ["3 cells"]),
        ("1.0,2.0,", ["3 cells", "ends with a column sign", "end the header with one, too"]),
        ("1,5,2,5", ["4 cells", "semicolons"]),
        ('"1,5",2.0', ["decimal sign"]),
        ('"1.234,5",2.0', ["thousands separators"]),
        ("1.5D-05,2.0", ["'1.5D-05'", "with E in exponents"]),
        ("\u22121.5,2.0", ["plain minus sign"]),
        ("1.5 Nm,2.0", ["a number alone", "remove it from the rows"]),
        ("1\u202f234.5,2.0", ["thousands separators"]),
        ("1\u2019234.5,2.0", ["thousands separators"]),
        ("0x10,1", ["'0x10'"]),
        ("1_000,1", ["'1_000'"]),
        ("True,1", ["'True'"]),
        ("\u0661,1", ["'\u0661'"]),
        ('"1.0,2.0', ["1 cell"]),
    ],
)
@pytest.mark.parametrize("row", [2, 57, len(LINES)])
def test_a_bad_row_is_named(tmp_path: Path, row: int, line: str, words: list[str]) -> None:
    text = changed(row, line) + ("1.0,2.0\n" if line == "," else "")
    message = refused(write(tmp_path / "loop.csv", text))
    assert message.startswith(f"loop.csv, row {row}")
    for word in words:
        assert word in message


@pytest.mark.parametrize("sign", [",", " ", "\t"])
def test_a_header_without_a_name_for_row_numbers_is_told(tmp_path: Path, sign: str) -> None:
    """As R's write.table has it; decimal commas were suspected."""
    lines = [f'"{n}"{sign}{line}' for n, line in enumerate(rows(*two_sided(), sign=sign)[1:], 1)]
    text = "\n".join([f'"torque_Nm"{sign}"angle_rad"', *lines])
    message = refused(write(tmp_path / "loop.csv", text))
    assert "row 2: found 3 cells; expected 2" in message
    assert "may lack the name of the first column" in message
    assert "semicolons" not in message


def test_rows_that_all_have_other_columns_than_the_header_are_told(tmp_path: Path) -> None:
    """The one row was to be removed, and then the next."""
    for end in (",Comment", ","):
        text = table().replace("angle_rad", "angle_rad" + end)
        message = refused(write(tmp_path / "a.csv", text))
        assert "row 2: found 2 cells; expected 3" in message
        assert "remove that from the header" in message
    text = "\n".join(["torque_Nm\tangle_rad", *(line.replace(",", "  ") for line in LINES[1:])])
    assert "by the sign that parts those of the header" in refused(write(tmp_path / "a.csv", text))


ERRORS = (
    *("#N/A", "#DIV/0!", "#VALUE!", "#REF!", "#NUM!", "#NAME?", "#NULL!", "#SPILL!"),
    *("#NV", "#WERT!", "#BEZUG!", "#ZAHL!", "#ÜBERLAUF!", "###", "########"),
)


@pytest.mark.parametrize("error", ERRORS)
@pytest.mark.parametrize("row", [2, 57])
@pytest.mark.parametrize("sign", [",", ";", " "])
def test_a_failed_cell_of_a_spreadsheet_is_no_comment(
    tmp_path: Path, error: str, row: int, sign: str
) -> None:
    text = changed(row, f"{error},0.001").replace(",", sign)
    message = refused(write(tmp_path / "a.csv", text))
    assert message.startswith(f"a.csv, row {row}, column 'torque_Nm': found '{error}'")
    # Remarks may speak of such an error, and a column that is not read may hold one.
    remarks = [f"{error} in the sheet", f"{error}"]
    remarks.append(f"#{error}{sign}0" if error[1] != "#" else f"{error}{sign}new")
    for remark in remarks:
        assert len(read_loop(write(tmp_path / "a.csv", changed(row, remark)))) == TORQUE.size - 1
    if error[1] == "#":
        text = changed(row, f"{error},{error}").replace(",", sign)
        assert f"row {row}, column 'torque_Nm'" in refused(write(tmp_path / "a.csv", text))
    lines = [f"{error if n == row else n}{sign}{line}" for n, line in enumerate(LINES[1:])]
    whole = "\n".join(["n,torque_Nm,angle_rad", *lines]).replace(",", sign)
    assert len(read_loop(write(tmp_path / "a.csv", whole))) == TORQUE.size


@pytest.mark.parametrize("cell", [200_000 * "x", '"' + 200_000 * "x" + '"'])
def test_a_cell_without_end_is_refused_in_words(tmp_path: Path, cell: str) -> None:
    """It ended as a mistake of the program."""
    header = f"torque_Nm,angle_rad,{cell}\n1,2,3\n"
    assert "row 1: found a cell of more than" in refused(write(tmp_path / "a.csv", header))
    text = "torque_Nm,angle_rad,note\n" + "".join(f"{line},n\n" for line in LINES[1:])
    for row in (2, 40):
        lines = text.split("\n")
        lines[row - 1] = lines[row - 1].removesuffix("n") + cell
        path = write(tmp_path / "a.csv", "\n".join(lines))
        if row == 2 or cell[0] == '"':
            assert f"row {row}: found a cell of more than" in refused(path)
        else:
            assert len(read_loop(path)) == TORQUE.size  # of a text that is not read


def test_rows_are_counted_as_an_editor_does(tmp_path: Path) -> None:
    text = "# one\r\n\r\n" + "\r\n".join([LINES[0], "# four", *LINES[1:30], "oops,1"])
    assert refused(write(tmp_path / "a.csv", text)).startswith("a.csv, row 34, column 'torque_Nm'")


def thousands(values: np.ndarray) -> list[str]:
    return [f"{value:,.0f}" for value in values]


@pytest.mark.parametrize("sign", ["\t", ";", "quoted"])
@pytest.mark.parametrize("block", [257, 8 << 20])
def test_commas_that_part_thousands_are_no_decimal_signs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sign: str, block: int
) -> None:
    monkeypatch.setattr(text_stream, "_BLOCK_BYTES", block)
    cells = zip(thousands(1e3 * TORQUE), thousands(1e6 * ANGLE), strict=True)
    text = "torque_mNm;angle_urad\n" + "".join(f"{one};{other}\n" for one, other in cells)
    if sign == "quoted":
        text = '"' + text.replace(";", '","').replace("\n", '"\n"')[:-1]
    message = refused(write(tmp_path / "a.csv", text.replace(";", sign)))
    assert "column 'torque_mNm': found '1,200', and numbers without a comma" in message
    assert message.startswith("a.csv, row 5")
    assert "'1,200' may be 1200 or 1.200" in message


def test_decimal_commas_are_read_with_fixed_decimals_and_without_trailing_zeros(
    tmp_path: Path,
) -> None:
    for torque in (
        [f"{value:.3f}" for value in TORQUE],
        [f"{value + 100:.3f}" for value in TORQUE],  # no cell below 1 that would show the sign
        [f"{value:.4g}" for value in TORQUE],
        [f"{value:.10g}" for value in TORQUE / 3],
    ):
        lines = [f"{one};{other:.9g}" for one, other in zip(torque, ANGLE, strict=True)]
        text = "\n".join(["torque_Nm;angle_rad", *lines]).replace(".", ",")
        loop = read_loop(write(tmp_path / "a.csv", text))
        assert loop.torque == pytest.approx([float(cell) for cell in torque])


@pytest.mark.parametrize("sign", [",", "\t", ";"])
@pytest.mark.parametrize("block", [257, 8 << 20])
@pytest.mark.parametrize("angle", [".9g", ".0f"])
def test_points_that_part_thousands_are_no_decimal_signs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sign: str, block: int, angle: str
) -> None:
    monkeypatch.setattr(text_stream, "_BLOCK_BYTES", block)
    torque = [cell.replace(",", ".") for cell in thousands(1e3 * TORQUE)]
    lines = [f"{one}{sign}{1e6 * other:{angle}}" for one, other in zip(torque, ANGLE, strict=True)]
    text = "\n".join([f"torque_mNm{sign}angle_urad", *lines])
    message = refused(write(tmp_path / "a.csv", text))
    assert message.startswith("a.csv, row 5, column 'torque_mNm': found '1.200'")
    assert "'1.200' may be 1200 or 1.200" in message


def test_decimal_points_are_read_with_fixed_decimals_and_without_trailing_zeros(
    tmp_path: Path,
) -> None:
    large = np.round(25 * TORQUE)  # to 1000
    for torque in (
        [f"{value:.3f}" for value in TORQUE],
        [f"{value + 100:.3f}" for value in TORQUE],  # no cell below 1 that would show the sign
        [f"{value:.4g}" for value in TORQUE],
        [f"{value:.10g}" for value in TORQUE / 3],
        [f"{value:g}" for value in 1 + np.round(TORQUE) / 8],  # 1, 1.125, 1.25
        [f"{value:.0f}" for value in large],
        # Integers to 100, and numbers below ten to three digits: no thousands, without hundreds.
        [f"{value:.3f}" if 1 <= abs(value) < 10 else f"{value:.0f}" for value in TORQUE],
        # A writer that parts thousands would not leave 1603 whole.
        ["1.203" if value == 100 else f"{value:.0f}" for value in large + 603],
    ):
        lines = [f"{one},{other:.9g}" for one, other in zip(torque, ANGLE, strict=True)]
        loop = read_loop(write(tmp_path / "a.csv", "\n".join(["torque_Nm,angle_rad", *lines])))
        assert loop.torque == pytest.approx([float(cell) for cell in torque])


@pytest.mark.parametrize("sign", [".", ","])
def test_decimal_signs_may_not_change(tmp_path: Path, sign: str) -> None:
    lines = table("torque_Nm;angle_rad", ";").replace(".", sign).splitlines()
    lines[200] = "1,5;2" if sign == "." else "1.5;2"
    message = refused(write(tmp_path / "a.csv", "\n".join(lines)))
    assert "row 201, column 'torque_Nm'" in message
    assert "decimal sign" in message


@pytest.mark.parametrize("name", ['"DB1".{} [{}]', "Rig's {} [{}]", "{} $raw [{}]", "{}<raw> {}"])
def test_a_proposed_option_is_taken_by_a_shell(tmp_path: Path, name: str) -> None:
    """Quotation marks in names, as traces of a PLC have them, ended the option's own."""
    names = (name.format("torque", "Nm"), name.format("angle", "rad"))
    header = "\t".join('"' + one.replace('"', '""') + '"' for one in names)
    path = write(tmp_path / "a.csv", table(header, "\t"))
    proposed = refused(path).partition("with --columns ")[2].partition(" (or the same")[0]
    told = ["sh", "-c", f"printf %s {proposed}"]
    option = subprocess.run(told, capture_output=True, check=True, text=True).stdout
    assert len(read_loop(path, columns=option)) == TORQUE.size


def test_a_row_of_units_is_explained(tmp_path: Path) -> None:
    text = "\n".join(["torque_Nm,angle_rad", "Nm,rad", *LINES[1:]])
    assert "units into the header" in refused(write(tmp_path / "a.csv", text))


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("torque,angle", ["--columns torque=torque:Nm,angle=angle:rad", "kNm", "arcmin"]),
        ("torque_Nm,angle", ["--columns angle=angle:rad"]),
        ("torque_out,Winkel [rad]", ["no column for the torque", "torque=torque_out:Nm"]),
        ("torque_cmd_Nm,torque_meas_Nm", ["torque=torque_meas_Nm:Nm"]),
        ("torque_act_kNm,Winkel ist [mrad]", ["torque=torque_act_kNm:kNm,angle=HEADER:rad"]),
        ("torque_Nm,Angle actual [deg]", ['--columns "angle=Angle actual [deg]:deg"']),
        ("Angle ist [deg] (rel.),torque_mNm (raw)", ["(rel.):deg", "torque_mNm (raw):mNm"]),
        ("input_torque_Nm,angle_rad", ["torque=HEADER:Nm"]),
        ("torque_a_Nm,torque_b_Nm", ["torque=HEADER:Nm"]),
        ("torque_Nm,output_angle_rad", ["angle=HEADER:rad"]),
        ("x,y", ["no column for the torque and the angle", "torque=HEADER:Nm,angle=HEADER:rad"]),
        ("Joint 3 of 2024-05-02", ["lines stand above", "remove them or begin them with #"]),
        ("torque_Nm,torque_Nm", ["the column 'torque_Nm' twice"]),
        ("torque_Nm,Torque [kNm]", ["more than one column for the torque"]),
        ("Torque [bananas],angle_rad", ["unit 'bananas'", "in·lbf"]),
        ("torque_s,angle_rad", ["unit 's'", "unit of torque"]),
        ("1.0,2.0", ["numbers: 1.0, 2.0", "names of the columns"]),
    ],
)
def test_headers(tmp_path: Path, header: str, words: list[str]) -> None:
    message = refused(write(tmp_path / "a.csv", table(header)))
    assert message.startswith("a.csv, header in row 1")
    for word in words:
        assert word in message


@pytest.mark.parametrize("units", ["Nm,mrad", "[Nm],[mrad]", "(Nm), (mrad)"])
def test_a_row_of_units_is_told_at_once(tmp_path: Path, units: str) -> None:
    """--columns was proposed, with units of its own; the file was then refused for that row."""
    text = f"Torque,Angle\n{units}\n" + "\n".join(LINES[1:])
    message = refused(write(tmp_path / "a.csv", text))
    assert message.startswith("a.csv, header in row 1: found a row of units below the header (")
    assert "Write Torque [Nm] and Angle [mrad] there, and remove the row of units." in message
    assert "--columns" not in message
    # With a number there, or where not all lack it, nothing is a row of units.
    for row in ("1,2", "Nm,2", "x,y"):
        text = f"Torque,Angle\n{row}\n" + "\n".join(LINES[1:])
        assert "--columns torque=Torque:Nm" in refused(write(tmp_path / "a.csv", text))


@pytest.mark.parametrize(("below", "contradicts"), [("mNm,rad", True), ("N m,rad", False)])
def test_a_row_of_units_that_contradicts_the_header_is_told(
    tmp_path: Path, below: str, contradicts: bool
) -> None:
    """With that row removed, as was advised, torques were a thousand times too large."""
    text = f"torque_Nm,angle_rad\n{below}\n" + "\n".join(LINES[1:])
    message = refused(write(tmp_path / "a.csv", text))
    assert ("no other unit than the column's, which is Nm" in message) == contradicts
    assert ("which of the two is right" in message) == contradicts
    assert "remove the row" in message


def test_a_time_without_unit_can_be_given_one_or_left_out(tmp_path: Path) -> None:
    lines = [f"{line},{n}" for n, line in enumerate(LINES[1:])]
    path = write(tmp_path / "a.csv", "\n".join([LINES[0] + ",time", *lines]))
    message = refused(path)
    assert "--columns time=time:s" in message
    assert "--columns time=" in message
    assert read_loop(path, columns="time=").time is None
    assert read_loop(path, columns="time=time:ms").time is not None


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ("torque=TORQ:Nm", "no column 'TORQ'"),
        ("torque=torque_Nm:rad", "unit 'rad' in --columns or in [columns] of drive.toml"),
        (
            "torque=torque_Nm:kNm",
            "Nm in the header and kNm in --columns or in [columns] of drive.toml; expected one "
            "unit. Leave the unit out there",
        ),
        ("angle=Angle_rad:furlong", "unit 'furlong'"),
    ],
)
def test_columns_that_do_not_fit(tmp_path: Path, columns: str, words: str) -> None:
    assert words in refused(write(tmp_path / "a.csv", table()), columns)


def zipped() -> bytes:
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        archive.writestr("a.csv", table())
    return memory.getvalue()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "nothing in it"),
        (b"\n\n# only this\n", "nothing in it"),
        (b"torque_Nm,angle_rad\n", "no row of data below the header"),
        (b"torque_Nm,angle_rad\n\n#\n", "after row 1"),
        (bytes(range(256)) * 40, "not a text file"),
        (table().encode("utf-16-le"), "not a text file"),
        (b"\xff\xfe" + table().encode("utf-16-le")[:-1], "UTF-16"),
        (gzip.compress(table().encode())[:-20], "damaged gzip"),
        (gzip.compress(bytes(range(256)) * 40), "not a text file"),
        (b"\x1f\x8bnonsense", "damaged gzip"),
        (zipped(), "no readable Excel workbook"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + b"\0" * 600, ".xls"),
        (b"\x89PNG\r\n\x1a\n" + b"\0" * 100, "not a text file"),
    ],
)
def test_what_is_no_table(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    assert words in refused(path)


def test_paths_that_are_no_file(tmp_path: Path) -> None:
    assert "no such file" in refused(tmp_path / "none.csv")
    assert "a folder" in refused(tmp_path)
    assert "cannot be read" in refused(tmp_path / ("x" * 500))


def test_a_bomb_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_stream, "_LARGEST_TEXT", 1 << 20)
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(b"torque_Nm,angle_rad\n" + b"0,0\n" * 1_000_000))
    assert "GiB of text" in refused(path)


def test_times_that_run_backwards_are_named(tmp_path: Path) -> None:
    lines = [f"{line},{n if n != 70 else 60}" for n, line in enumerate(LINES[1:])]
    message = refused(write(tmp_path / "a.csv", "\n".join([LINES[0] + ",time_s", *lines])))
    assert message.startswith("a.csv, row 72, column 'time_s'")
    assert "9 s before that of row 71" in message


@pytest.mark.parametrize(
    ("torque", "words"),
    [
        (ramps(0, PEAK, 0, samples=10)[:19], "19 samples"),
        (np.full(200, 3.0), "the same torque"),
        (3.0 + 0.1 * np.random.default_rng(0).standard_normal(500), "no more than its noise"),
        (ramps(0, PEAK, samples=200), "unloading 0%"),
        (ramps(PEAK, 0, samples=200), "loading covers 0%"),
        (ramps(-PEAK, PEAK, samples=200), "full loading and unloading"),
        (ramps(0, PEAK, PEAK / 2), "unloading 50%"),
        (ramps(0, PEAK, PEAK, samples=300), "full loading and unloading"),
    ],
)
def test_less_than_a_loop(tmp_path: Path, torque: np.ndarray, words: str) -> None:
    text = "\n".join(["torque_Nm,angle_rad", *rows(torque, twist(torque))])
    assert words in refused(write(tmp_path / "a.csv", text))


def test_an_angle_that_never_changes(tmp_path: Path) -> None:
    text = "\n".join(["torque_Nm,angle_rad", *rows(TORQUE, np.full(TORQUE.size, 0.1))])
    assert "the same angle" in refused(write(tmp_path / "a.csv", text))


@pytest.mark.parametrize(
    "torque",
    [
        ramps(0, PEAK, 0),
        ramps(PEAK, 0, PEAK),
        ramps(-PEAK, PEAK, -PEAK),
        ramps(0, PEAK, -PEAK),
        ramps(0, PEAK, 30, 35, 20, 25, 0),
        ramps(10, PEAK, 10),
        ramps(0, -PEAK, 0, -PEAK, 0),
        ramps(0, 20, 15, PEAK, 0),
    ],
)
def test_loops_of_every_shape_are_welcome(tmp_path: Path, torque: np.ndarray) -> None:
    text = "\n".join(["torque_Nm,angle_rad", *rows(torque, twist(torque))])
    assert len(read_loop(write(tmp_path / "a.csv", text))) == torque.size


newton_metre = find_unit("Nm")
assert newton_metre is not None
CELL = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.integers(-1000, 1000).map(str),
    st.text("0123456789.,eE+-_ xTrueFalsnaif", max_size=6),
    st.sampled_from(["", " 1.5", "1.5 ", "True", "nan", "-inf", "1e5", "1.", ".5", "1e400"]),
    st.sampled_from(["1,250", "-12,500", "0,125", "1,25", "1,2e5", "1250,125", "25", " 1,250"]),
    st.sampled_from(["1.250", "-12.500", "0.125", "1.2e5", "1250.125", "250", "1250", " 1.250"]),
)


@given(st.lists(st.tuples(CELL, CELL), min_size=1, max_size=6), st.sampled_from(",;\t"))
@settings(max_examples=300, deadline=None)
def test_the_fast_way_reads_what_the_careful_way_reads(
    cells: list[tuple[str, str]], sign: str
) -> None:
    """Whatever is in the cells, a block is read alike or left to the parser that decides."""
    lines = [sign.join(pair) for pair in cells]
    text = ("torque_Nm" + sign + "angle_rad\n" + "\n".join(lines) + "\n").encode()

    def outcome(careful: bool) -> object:
        reader = _TextTable("a.csv", None, None)
        if careful:
            reader._fast = lambda *_: None  # type: ignore[method-assign]
        try:
            blocks = list(reader.read(text))
            reader.finished_layout()
        except BadInputError as error:
            return str(error)
        return [
            (block.rows.tolist(), block.values["torque"], block.values["angle"]) for block in blocks
        ]

    fast, careful = outcome(False), outcome(True)
    if isinstance(fast, str) or isinstance(careful, str):
        assert fast == careful
        return
    assert isinstance(fast, list)
    assert isinstance(careful, list)
    for (rows_a, *values_a), (rows_b, *values_b) in zip(fast, careful, strict=True):
        assert rows_a == rows_b
        for one, other in zip(values_a, values_b, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-15)


@given(st.binary(max_size=400))
@settings(max_examples=150, deadline=None)
def test_any_bytes_end_in_words(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(content)
    with pytest.raises(BadInputError):
        read_loop(path)


def test_blocks_join_without_a_seam(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_stream, "_BLOCK_BYTES", 257)
    text = table().replace("\n", "\r\n")
    loop = read_loop(write(tmp_path / "a.csv", text))
    assert loop.torque == pytest.approx(TORQUE)
    bad = changed(301, "x,1").replace("\n", "\r\n")
    assert "row 301, column" in refused(write(tmp_path / "b.csv", bad))


def test_the_parser_remembers_the_decimal_sign_between_blocks() -> None:
    column = Column("torque", 0, "torque_Nm", newton_metre)
    parser = RowParser(Layout("a.csv", 1, ("torque_Nm",), (column,)))
    assert parser.parse([(2, ["1,5"])]).values["torque"].tolist() == [1.5]
    with pytest.raises(BadInputError, match="decimal sign ','"):
        parser.parse([(3, ["1.5"])])


def test_a_column_is_not_torque_and_angle_at_once(tmp_path: Path) -> None:
    words = refused(write(tmp_path / "a.csv", table()), columns="angle=torque_Nm:rad")
    assert "the column 'torque_Nm' as the torque and as the angle" in words
    assert "--columns torque=HEADER,angle=HEADER" in words


def test_what_a_record_does_without_may_be_left_out(tmp_path: Path) -> None:
    """A temperature that is logged at every tenth reading."""
    lines = [f"{line},{20.5 if n % 10 == 0 else ''}" for n, line in enumerate(LINES[1:])]
    path = write(tmp_path / "loop.csv", "\n".join([f"{LINES[0]},temperature_C", *lines]) + "\n")
    assert "--columns temperature= leaves it out" in refused(path)
    assert read_loop(path, columns="temperature=").temperature is None
    torque = write(tmp_path / "torque.csv", changed(5, ",1e-3"))
    assert "leaves it out" not in refused(torque)


def test_points_between_thousands_among_decimal_commas(tmp_path: Path) -> None:
    lines = table("torque_Nm;angle_rad", ";").replace(".", ",").splitlines()
    lines[40] = "1.026;" + lines[40].partition(";")[2]
    path = write(tmp_path / "loop.csv", "\n".join(lines) + "\n")
    assert "without thousands separators" in refused(path)
