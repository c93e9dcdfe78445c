"""A drive goes out of the store as a folder and comes in again the same."""

from __future__ import annotations

import csv
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

from hdprog.data.drive_folder import read_drive_folder
from hdprog.errors import BadInputError
from hdprog.service.importing import take_in_folders
from hdprog.service.queue import Queue
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import find_drive, fleet
from hdprog.store.folder import export_drive, import_drive, require_importable
from hdprog.store.store import Store, open_store
from hdprog.store.uploads import TestFacts, list_tests
from tests.store.samples import WEARING, add_bytes, add_sample
from tests.workflow.test_run import edit, subset


def take_in(store: Store, folder: Path) -> None:
    looked = {test.path: (dict[str, Any](), "<svg/>") for test in read_drive_folder(folder).tests}
    with store.writing() as session:
        import_drive(session, store.files, COMMAND_LINE, folder, looked)


def test_out_and_in_again_is_the_same(store: Store, tmp_path: Path) -> None:
    take_in(store, WEARING)
    out = tmp_path / "out"
    with store.reading() as session:
        drive = find_drive(session, "wearing-csf-25-80")
        assert drive is not None
        assert export_drive(session, store.files, drive, out) == 10
    before, after = read_drive_folder(WEARING), read_drive_folder(out)
    assert tomllib.loads((out / "drive.toml").read_text()) == tomllib.loads(
        (WEARING / "drive.toml").read_text()
    )
    for one, other in zip(before.tests, after.tests, strict=True):
        assert (one.test_id, one.service_hours) == (other.test_id, other.service_hours)
        assert one.path.read_bytes() == other.path.read_bytes()


def test_all_that_was_said_of_a_test_goes_out(store: Store, tmp_path: Path) -> None:
    said = TestFacts(
        12.5,
        label="t 1",
        temperature_C=31.5,
        note='new "grease", 5 g\nsecond line',
        event="regreased",
        mean_torque_Nm=20.25,
        mean_speed_rpm=1500.0,
    )
    with store.writing() as session:
        drive = add_sample(session)
        add_bytes(session, store.files, drive, b"a", said, name="a.CSV.GZ")
    with store.reading() as session:
        drive = find_drive(session, "cell3-axis2")
        assert drive is not None
        export_drive(session, store.files, drive, tmp_path / "out")
    [test] = read_drive_folder(tmp_path / "out").tests
    assert test.path.name == "t 1.csv.gz"
    assert test.note == 'new "grease", 5 g second line'
    assert (test.event, test.temperature_C, test.service_hours) == ("regreased", 31.5, 12.5)
    assert (test.mean_torque_Nm, test.mean_speed_rpm) == (20.25, 1500.0)


def test_a_folder_with_one_wrong_record_leaves_nothing(store: Store, tmp_path: Path) -> None:
    folder = tmp_path / "drive"
    shutil.copytree(WEARING, folder)
    shutil.copy(folder / "loops" / "t01.csv", folder / "loops" / "t02.csv")
    with pytest.raises(BadInputError, match="same record as that of test t01"):
        take_in(store, folder)
    with store.reading() as session:
        assert find_drive(session, "wearing-csf-25-80") is None


def test_of_folders_of_which_one_is_wrong_none_is_taken_in(tmp_path: Path) -> None:
    """Those before it stayed in, and the same command again refused them as there already."""
    right = subset(tmp_path / "right", ["t01"])
    names = ("id", "same", "text", "note")
    faults = {name: subset(tmp_path / name, ["t01", "t02"]) for name in names}
    for name, folder in faults.items():
        edit(folder, 'id = "wearing-csf-25-80"', f'id = "{"a/b" if name == "id" else name}"')
    shutil.copy(faults["same"] / "loops" / "t01.csv", faults["same"] / "loops" / "t02.csv")
    (faults["text"] / "loops" / "t02.csv").write_text("no record", "utf-8")
    table = faults["note"] / "tests.csv"
    first, *rows = table.read_text("utf-8").splitlines()
    table.write_text("\n".join([f"{first},note", *(f"{row},\x07" for row in rows)]), "utf-8")
    with open_store(tmp_path / "data") as store:
        queue = Queue(store.database.url)
        for wrong in (right, *faults.values()):
            with pytest.raises(BadInputError):
                list(take_in_folders(store, queue, [right, wrong]))
        queue.close()
        with store.reading() as session:
            assert fleet(session).found == 0
        assert not list(store.files.raw.rglob("*"))


@pytest.mark.parametrize("there", [False, True])
def test_the_folder_that_is_wrong_is_named(store: Store, tmp_path: Path, there: bool) -> None:
    """Of several the words did not say which."""
    right, wrong = (subset(tmp_path / name, ["t01"]) for name in ("right", "wrong"))
    edit(right, 'id = "wearing-csf-25-80"', 'id = "other"')
    if there:
        with store.writing() as session:
            add_sample(session, "wearing-csf-25-80")
    else:
        edit(wrong, 'id = "wearing-csf-25-80"', 'id = "a/b"')
    with store.reading() as session:
        assert require_importable(session, right) == "other"
        with pytest.raises(BadInputError) as raised:
            require_importable(session, wrong)
    assert str(raised.value).startswith(f"{wrong}, drive settings, [drive]")


def test_removed_tests_stay_behind(store: Store, tmp_path: Path) -> None:
    take_in(store, WEARING)
    with store.writing() as session:
        drive = find_drive(session, "wearing-csf-25-80")
        assert drive is not None
        list_tests(session, drive, "accepted")[0].state = "removed"
    with store.reading() as session:
        drive = find_drive(session, "wearing-csf-25-80")
        assert drive is not None
        assert export_drive(session, store.files, drive, tmp_path / "out") == 9


def test_records_whose_names_would_be_one_go_out_as_two(store: Store, tmp_path: Path) -> None:
    """An analysis had taken the second record for both tests."""
    names = {"t01": "a.csv.gz", "t01.csv": "b.gz"}
    out = tmp_path / "out"
    with store.writing() as session:
        drive = add_sample(session)
        for hours, (label, name) in enumerate(names.items()):
            facts = TestFacts(float(hours), label=label)
            add_bytes(session, store.files, drive, label.encode(), facts, name=name)
        session.flush()
        assert export_drive(session, store.files, drive, out) == 2
    with (out / "tests.csv").open(encoding="utf-8") as file:
        files = {row["test_id"]: row["file"] for row in csv.DictReader(file)}
    assert {label: (out / name).read_bytes().decode() for label, name in files.items()} == {
        label: label for label in names
    }
