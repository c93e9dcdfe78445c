from __future__ import annotations

import datetime
import gzip
import json
from pathlib import Path

import pytest

from hdprog.config import Drive
from hdprog.data.check import check_path
from hdprog.data.drive_folder import read_drive_folder, read_test_loop, read_test_loops
from hdprog.errors import BadInputError
from tests.data.samples import table, write

HEADER = "test_id,file,service_hours,date,temperature_C,note,event,mean_torque_Nm,mean_speed_rpm"
ROWS = (
    't02,loops/b.csv,900.5,2025-03-09,25.5,"slow, warm",regreased,30,1500',
    "t01,loops/a.csv,0,,,,,,",
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    drive = tmp_path / "rig"
    (drive / "loops").mkdir(parents=True)
    write(drive / "drive.toml", '[drive]\nid = "x"\n[columns]\ntorque = "T:kNm"\n')
    write(drive / "tests.csv", "\n".join([HEADER, *ROWS]) + "\n\n")
    for number, name in enumerate("ab"):
        lines = table("T,angle_mrad").splitlines()
        write(drive / "loops" / f"{name}.csv", "\n".join([lines[0], *lines[1 : 400 + number]]))
    return drive


def refused(folder: Path) -> str:
    with pytest.raises(BadInputError) as caught:
        read_drive_folder(folder)
    return str(caught.value)


def test_tests_come_by_service_hours_and_whole(folder: Path) -> None:
    found = read_drive_folder(folder)
    assert found.drive.id == "x"
    first, second = found.tests
    assert (first.test_id, first.service_hours) == ("t01", 0.0)
    assert (first.date, first.note, first.event, first.mean_torque_Nm) == (None,) * 4
    assert second.date == datetime.date(2025, 3, 9)
    assert (second.temperature_C, second.note, second.event) == (25.5, "slow, warm", "regreased")
    assert (second.mean_torque_Nm, second.mean_speed_rpm) == (30.0, 1500.0)
    assert second.path == folder / "loops" / "b.csv"
    loop = read_test_loop(found, first)
    assert loop.torque.max() == pytest.approx(40_000.0)


@pytest.mark.parametrize("hint", ["", "sep=;\r\n"])
def test_only_three_columns_are_needed(folder: Path, hint: str) -> None:
    # As a German Excel writes it, on Windows.
    text = f"\ufeff{hint}test_id;file;service_hours;operator\r\nt1;loops\\a.csv;12,5;Jörg\r\n"
    write(folder / "tests.csv", text)
    [test] = read_drive_folder(folder).tests
    assert (test.service_hours, test.path) == (12.5, folder / "loops/a.csv")


@pytest.mark.parametrize(("cell", "number"), [("12,500", "12500"), ("1,250,000", "1250000")])
def test_a_comma_that_may_part_thousands_is_refused(folder: Path, cell: str, number: str) -> None:
    write(folder / "tests.csv", f"test_id;file;service_hours\nt01;loops/a.csv;{cell}\n")
    message = refused(folder)
    assert f"tests.csv, row 2: found service_hours = '{cell}'" in message
    assert f"like {number} or {number}.0" in message


def write_hours(folder: Path, cells: tuple[str, ...]) -> None:
    lines = [f't{n},loops/a.csv,"{cell}"' for n, cell in enumerate(cells)]
    write(folder / "tests.csv", "\n".join(["test_id,file,service_hours", *lines]))


def test_points_that_part_thousands_are_refused(folder: Path) -> None:
    write_hours(folder, ("250", "750", "1.250", "1.750"))
    message = refused(folder)
    assert "row 4: found service_hours = '1.250', whose point seems to part thousands" in message
    assert "expected 1250 for the one, 1.2500 for the other" in message


@pytest.mark.parametrize("column", ["service_hours", "mean_torque_Nm"])
def test_points_beside_decimal_commas_are_refused(folder: Path, column: str) -> None:
    """1.234 hours, as a German spreadsheet shows 1234, were read as 74 minutes."""
    header = ["test_id", "file", "temperature_C", "service_hours", "mean_torque_Nm"]
    cells = dict.fromkeys(header[3:], "7.5") | {column: "1.234"}
    row = f"t1;loops/a.csv;21,5;{';'.join(cells.values())}"
    write(folder / "tests.csv", ";".join(header) + "\n" + row)
    message = refused(folder)
    assert f"row 2: found {column} = '1.234', whose point seems to part thousands" in message
    assert "expected 1234 for the one, 1,2340 for the other" in message
    write(folder / "tests.csv", (";".join(header) + "\n" + row).replace("21,5", "21.5"))
    assert getattr(read_drive_folder(folder).tests[0], column) == 1.234


@pytest.mark.parametrize("other", ["500", "2.500"])
def test_points_alone_in_a_table_of_semicolons_are_refused(folder: Path, other: str) -> None:
    """No comma tells what they are, and a German spreadsheet shows whole hours so."""
    lines = ["test_id;file;service_hours", "t1;loops/a.csv;1.234", f"t2;loops/b.csv;{other}"]
    write(folder / "tests.csv", "\n".join(lines))
    message = refused(folder)
    assert "row 2: found service_hours = '1.234', whose point seems to part thousands" in message
    assert "expected 1234 for the one, 1,2340 for the other" in message
    write(folder / "tests.csv", "\n".join([*lines, "t3;loops/b.csv;900.5"]))
    assert read_drive_folder(folder).tests[0].service_hours == 1.234


@pytest.mark.parametrize(
    "cells",
    [
        ("0", "128.571", "257.143"),
        ("1.250", "900.5", "1200"),
        ("750", "1.250", "2.500", "800"),  # in no order by either reading
    ],
)
def test_points_that_may_be_decimal_signs_are_read(folder: Path, cells: tuple[str, ...]) -> None:
    write_hours(folder, cells)
    hours = [test.service_hours for test in read_drive_folder(folder).tests]
    assert hours == sorted(map(float, cells))


def test_commas_that_can_only_be_decimal_signs_are_read(folder: Path) -> None:
    write_hours(folder, ("0,500", "12,5", "12,5000", "1250,125"))
    hours = [test.service_hours for test in read_drive_folder(folder).tests]
    assert hours == [0.5, 12.5, 12.5, 1250.125]


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("t01,loops/a.csv,5", "row 3: found test_id 't01' a second time"),
        ("t03,loops/c.csv,5", "does not exist"),
        ("#N/A,loops/a.csv,5", "test_id '#N/A'"),
        ("t03,../a.csv,5", "outside the drive folder"),
        ("t03,/etc/passwd,5", "by an absolute path"),
        ("t03,C:\\a.csv,5", "by an absolute path"),
        ("t03,loops/../../a.csv,5", "outside the drive folder"),
        ("t03,link.csv,5", "outside the drive folder"),
        ("t03,,5", "no file"),
        ("t03,loops,5", "which is a folder"),
        ("t03,loops/a.csv,-1", "service_hours = '-1'"),
        ("t03,loops/a.csv,ten", "service_hours = 'ten'"),
        ("t03,loops/a.csv,nan", "service_hours = 'nan'"),
        ("t03,loops/a.csv,", "no service_hours"),
        (",loops/a.csv,5", "no test_id"),
        ("../t,loops/a.csv,5", "test_id '../t'"),
        ("試" * 90 + ",loops/a.csv,5", "scripts beyond Latin, Greek and Cyrillic fewer"),
        ("t03,loops/a.csv,5,09.03.2025", "date '09.03.2025'"),
        ("t03,loops/a.csv,5,,warm", "temperature_C = 'warm'"),
        ("t03,loops/a.csv,5,,-300", "temperature_C = '-300'"),
        ("t03,loops/a.csv,5,,1e9", "temperature_C = '1e9'"),
        ("t03,loops/a.csv,1e8", "service_hours = '1e8'"),
        ("t03,loops/a.csv,5,,,,greased", "regreased, reassembled, replaced"),
        ("t03,loops/a.csv,5,,,,,-3", "mean_torque_Nm = '-3'"),
        ("t03,loops/a.csv,5,,,one, two,regreased,1,2", "quotation marks"),
    ],
)
def test_rows_that_are_wrong(folder: Path, row: str, words: str) -> None:
    write(folder.parent / "a.csv", table())
    (folder / "link.csv").symlink_to(folder.parent / "a.csv")
    cells = row.count(",")
    if cells < 8:
        row += "," * (8 - cells)
    write(folder / "tests.csv", "\n".join([HEADER, ROWS[1], row]))
    message = refused(folder)
    assert "tests.csv, row 3" in message
    assert words in message


@pytest.mark.parametrize("typed", ["regreased", "Regreased", "REGREASED"])
def test_an_event_is_read_in_any_case(folder: Path, typed: str) -> None:
    write(folder / "tests.csv", "\n".join([HEADER, ROWS[1], f"t03,loops/a.csv,5,,,,{typed},,"]))
    assert "regreased" in [test.event for test in read_drive_folder(folder).tests]


@pytest.mark.parametrize("mark", ['"5 mm shim', '"5"" shim, new', '#,"'])
@pytest.mark.parametrize("closing", ["", '"greased"', 'replaced"'])
def test_a_quotation_that_swallows_tests_is_refused(folder: Path, mark: str, closing: str) -> None:
    """Tests behind it were left out without a word, and an event was taken for another test's."""
    rows = [
        "t01,loops/a.csv,0,," if mark[0] == '"' else "",
        f"t02,loops/b.csv,10,,{mark}" if mark[0] == '"' else mark,
        "t03,loops/a.csv,20,,",
        f"t04,loops/b.csv,30,,{closing}",
    ]
    write(folder / "tests.csv", "\n".join(["test_id,file,service_hours,event,note", *rows]))
    message = refused(folder)
    assert "tests.csv, row 3: found a quotation mark that begins a cell" in message
    assert "row 4, a test" in message


def test_a_note_without_end_is_refused_in_words(folder: Path) -> None:
    rows = ["t01,loops/a.csv,0,", 't02,loops/b.csv,0,"shim', *9_000 * ["t03,loops/none.csv,0,"]]
    write(folder / "tests.csv", "\n".join(["test_id,file,service_hours,note", *rows]))
    message = refused(folder)
    assert "tests.csv, row 3: found a cell of more than" in message
    assert "Close a quotation mark" in message


def test_notes_of_several_lines_are_read(folder: Path) -> None:
    notes = ['"cold\n1,2,3"', '"5"" shim\nloops/a.csv, 10\n"', '"\nt03,loops/none.csv,20,"']
    rows = [f"t{n},loops/a.csv,{n},{note}" for n, note in enumerate(notes)]
    write(folder / "tests.csv", "\n".join(["test_id,file,service_hours,note", *rows]))
    read = [test.note for test in read_drive_folder(folder).tests]
    assert read == ["cold\n1,2,3", '5" shim\nloops/a.csv, 10', "t03,loops/none.csv,20,"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "nothing in it"),
        ("test_id,file,service_hours\n", "no test below it"),
        ("test_id,file\nt,loops/a.csv\n", "no column service_hours"),
        ("test_id,file,service_hours,evnt\n", "Did you mean event"),
        ("test_id,file,service_hours,EVENT\n", "Did you mean event"),
        ("test_id,file,service_hours,MEAN_TORQUE_NM\n", "Did you mean mean_torque_Nm"),
        (
            "test_id,file,service_hours,maintenance\nt,loops/a.csv,0,Regreased\n",
            "'Regreased' in the column 'maintenance', which is not read",
        ),
        ("test_id,file,service_hours,file\n", "the column file twice"),
    ],
)
def test_tables_that_are_wrong(folder: Path, text: str, words: str) -> None:
    write(folder / "tests.csv", text)
    assert words in refused(folder)


def test_further_columns_with_names_like_those_known_are_passed_over(folder: Path) -> None:
    """They were taken for slips of the columns beside which they stand."""
    further = ("max_torque_Nm", "motor_temperature_C", "rate", "notes")
    known = "mean_torque_Nm,temperature_C,date,note"
    text = "test_id,file,service_hours," + known + "," + ",".join(further)
    write(folder / "tests.csv", text + "\nt01,loops/a.csv,0,3,20,,ok,9,60,,n\n")
    [test] = read_drive_folder(folder).tests
    assert (test.mean_torque_Nm, test.temperature_C, test.note) == (3.0, 20.0, "ok")
    for name in further:
        write(folder / "tests.csv", f"test_id,file,service_hours,{name}\nt01,loops/a.csv,0,3\n")
        assert f"the column '{name}'" in refused(folder)
    # Events in a column that is not read would be lost.
    for known, name in (("note", "Note"), ("event", "events")):
        header = f"test_id,file,service_hours,{known},{name}"
        write(folder / "tests.csv", f"{header}\nt01,loops/a.csv,0,,replaced\n")
        assert f"the column '{name}'" in refused(folder)


def test_folders_that_are_none(folder: Path) -> None:
    assert "no such folder" in refused(folder / "none")
    assert "a file" in refused(folder / "tests.csv")
    assert "without drive.toml" in refused(folder / "loops")
    (folder / "tests.csv").unlink()
    assert "no tests.csv" in refused(folder)


def test_check_of_a_sound_loop(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", table("torque,angle"))
    report = check_path(path, columns="torque=torque:Nm,angle=angle:rad", select=None, drive=None)
    assert report.ok
    assert report.kind == "loop"
    assert report.lines[0].startswith("a.csv: usable: 401 samples, 1.5 two-sided cycles")
    content = json.loads(json.dumps(report.as_json(), allow_nan=False))
    assert content["loops"][0]["samples"] == 401
    assert content["ok"] is True


def test_columns_that_nothing_is_read_from_are_named(tmp_path: Path) -> None:
    """A time by an unknown name left the record untimed without a word."""
    torque = [*range(41), *range(39, -1, -1)]
    rows = [f"{i},{t},{t * 2e-5},7,,up" for i, t in enumerate(torque)]
    header = "Sekunden,torque_Nm,angle_rad,Motor,,branch"
    path = write(tmp_path / "a.csv", "\n".join([header, *rows]) + "\n")
    lines = check_path(path).lines
    assert "  Not read: columns 'Sekunden', 'Motor', 'branch'" in lines
    assert "  Not read: columns 'Sekunden', 'Motor'" in check_path(path, select="branch=up").lines
    lines = check_path(path, columns="time=Sekunden:s,temperature=Motor:degC").lines
    assert "  Not read: column 'branch'" in lines
    path = write(tmp_path / "b.csv", table())
    assert not any("Not read" in line for line in check_path(path).lines)


def test_what_does_not_change_is_told_once(tmp_path: Path) -> None:
    """A steady test was told to be loaded "at 2 to 2 Nm/s", from "-0" Nm."""
    torque = [*range(41), *range(39, -1, -1)]
    rows = [f"{i},{t or -0.0},{t * 2e-5},24" for i, t in enumerate(torque)]
    header = "time_s,torque_Nm,angle_rad,temperature_C"
    path = write(tmp_path / "a.csv", "\n".join([header, *rows]) + "\n")
    said = " ".join(check_path(path).lines)
    assert "torque 0 to 40 Nm" in said
    assert "loaded at 1 Nm/s on average" in said
    assert "Temperature 24.0 °C" in said


def test_check_of_a_loop_that_is_refused(tmp_path: Path) -> None:
    report = check_path(write(tmp_path / "a.csv", table("torque,angle")))
    assert not report.ok
    assert report.lines == (f"Problem: {report.problems[0]}",)
    assert "--columns torque=torque:Nm" in report.problems[0]


def test_check_compares_with_the_drive_that_is_given(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", table())
    toml = write(tmp_path / "drive.toml", '[drive]\nid = "x"\nrated_torque_Nm = 40000\n')
    for drive in (toml, Drive(rated_torque=40_000.0)):
        report = check_path(path, drive=drive)
        assert report.ok
        assert any("rated torque" in warning for warning in report.warnings)


def test_check_of_a_folder_collects_all_problems(folder: Path) -> None:
    bad = [*ROWS, "t03,loops/c.csv,5,,,,,,", "t04,loops/d.csv,-5,,,,,,", "t05,loops/e.csv,7,,,,,,"]
    write(folder / "tests.csv", "\n".join([HEADER, *bad]))
    write(folder / "loops/d.csv", "")
    write(folder / "loops/e.csv", "T,angle_mrad\n1,x\n")
    report = check_path(folder)
    assert report.kind == "drive"
    assert len(report.problems) == 3
    for problem, words in zip(report.problems, ["row 4", "row 5", "e.csv, row 2"], strict=True):
        assert words in problem
    assert [name for name, _ in report.loops] == ["t01", "t02"]
    assert any("nothing can be forecast" in warning for warning in report.warnings)


def copied(folder: Path) -> list[str]:
    """Names of the tests that a run warns of as copies."""
    found = read_drive_folder(folder)
    return [
        test.test_id
        for test in found.tests
        if any("same as that" in said for said in read_test_loop(found, test).warnings)
    ]


def test_check_and_run_see_a_copied_file(folder: Path) -> None:
    assert copied(folder) == []
    (folder / "loops/b.csv").write_bytes((folder / "loops/a.csv").read_bytes())
    report = check_path(folder)
    assert report.ok
    [warning] = [warning for warning in report.warnings if "same as that" in warning]
    later, earlier = (test.test_id for test in reversed(read_drive_folder(folder).tests))
    assert warning.startswith(f"{later}: The file is the same as that of test {earlier}, byte by")
    assert copied(folder) == [later]


def in_another_form(record: bytes, form: str) -> bytes:
    """Give the same readings as other bytes."""
    if form == "gzip":
        return gzip.compress(record)
    if form == "line ends":
        return record.replace(b"\n", b"\r\n")
    return record.replace(b",", b";").replace(b".", b",")


@pytest.mark.parametrize("form", ["gzip", "line ends", "decimal comma"])
def test_check_and_run_see_the_same_readings_in_another_form(folder: Path, form: str) -> None:
    """They counted as two tests without a word."""
    assert not [
        doubt
        for loop in read_test_loops(read_drive_folder(folder))
        for doubt in loop.warnings
        if "reading by reading" in doubt
    ]
    (folder / "loops/b.csv").write_bytes(
        in_another_form((folder / "loops/a.csv").read_bytes(), form)
    )
    report = check_path(folder)
    assert report.ok
    [warning] = [warning for warning in report.warnings if "reading by reading" in warning]
    found = read_drive_folder(folder)
    later, earlier = (test.test_id for test in reversed(found.tests))
    assert warning.startswith(f"{later}: Torque and angle are those of test {earlier}, reading by")
    first, second = read_test_loops(found)
    assert not any("reading by reading" in doubt for doubt in first.warnings)
    assert any("reading by reading" in doubt for doubt in second.warnings)


def test_check_and_run_see_a_file_that_is_listed_twice(folder: Path) -> None:
    write_hours(folder, ("0", "100", "200"))
    assert copied(folder) == ["t1", "t2"]


def test_check_of_a_folder_without_its_files(folder: Path) -> None:
    assert "without drive.toml" in check_path(folder / "loops").problems[0]
    write(folder / "drive.toml", "[drive]\n")
    (folder / "tests.csv").unlink()
    problems = check_path(folder).problems
    assert "no id" in problems[0]
    assert "no tests.csv" in problems[1]


def test_a_unit_that_is_not_known_is_declared_in_the_drives_file(folder: Path) -> None:
    """The advice was an option that commands on a drive folder do not have."""
    (folder / "drive.toml").write_text('[drive]\nid = "x"\n')
    read = read_drive_folder(folder)
    record = read.tests[0].path
    record.write_text(record.read_text().replace("T,", "torque [kNmm],", 1))
    with pytest.raises(BadInputError, match=r"kNmm.*\[columns\] in its drive\.toml"):
        read_test_loop(read, read.tests[0])
    with (folder / "drive.toml").open("a") as file:
        file.write('[columns]\ntorque = "torque [kNmm]:Nm"\n')
    declared = read_drive_folder(folder)
    assert read_test_loop(declared, declared.tests[0]).torque.size > 20
