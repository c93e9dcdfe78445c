"""Tests of drives in the store: the same file once, names, states."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from datetime import date
from pathlib import Path

import pytest

from hdprog.errors import BadInputError
from hdprog.store.audit import COMMAND_LINE, trail
from hdprog.store.drives import find_drive
from hdprog.store.folder import export_drive
from hdprog.store.store import Store
from hdprog.store.uploads import (
    TestFacts,
    accept,
    find_test,
    list_tests,
    readable_name,
    refresh_counts,
    remove,
)
from tests.store.samples import add_bytes, add_sample


def test_the_same_file_twice_is_one_test(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        first, new = add_bytes(session, store.files, drive, b"a", TestFacts(10.0))
        assert new
        again, new = add_bytes(session, store.files, drive, b"a", TestFacts(20.0))
        assert not new
        assert again.id == first.id
        assert again.service_hours == 10.0


def test_the_same_file_may_be_a_test_of_another_drive(store: Store) -> None:
    with store.writing() as session:
        one, two = add_sample(session, "one"), add_sample(session, "two")
        first, _ = add_bytes(session, store.files, one, b"a", TestFacts(0.0, label="t01"))
        second, new = add_bytes(session, store.files, two, b"a", TestFacts(0.0, label="t01"))
        assert new
        assert (first.label, second.label) == ("t01", "t01")
        assert first.uid != second.uid


def test_a_preview_counts_once_it_is_accepted(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        test, _ = add_bytes(session, store.files, drive, b"a", TestFacts(), accepted=False)
        refresh_counts(session, drive)
        assert drive.tests == 0
        accept(session, COMMAND_LINE, test, TestFacts(5.0, event="regreased"))
        refresh_counts(session, drive)
        assert (drive.tests, drive.last_test_hours) == (1, 5.0)
    with store.reading() as session:
        found = find_test(session, test.uid)
        assert found is not None
        assert found.event is not None
        assert found.event.kind == "regreased"


def test_a_removed_test_can_come_back(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        test, _ = add_bytes(session, store.files, drive, b"a", TestFacts(1.0))
        remove(session, COMMAND_LINE, test)
        assert not list_tests(session, drive, "accepted")
        add_bytes(session, store.files, drive, b"a", TestFacts(2.0))
        assert [one.service_hours for one in list_tests(session, drive, "accepted")] == [2.0]


@pytest.mark.parametrize("label", ["../x", "a/b", "", " a", "a.", "=cmd()", "x" * 101, "試" * 67])
def test_labels_that_are_no_names(store: Store, label: str) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        with pytest.raises(BadInputError, match="test_id"):
            add_bytes(session, store.files, drive, b"a", TestFacts(0.0, label=label))


@pytest.mark.parametrize("label", ["x" * 100, "я" * 100, "試" * 66])
def test_a_drive_with_long_labels_goes_out(store: Store, tmp_path: Path, label: str) -> None:
    """A test with a name that no file can have kept its drive from being analysed for good."""
    with store.writing() as session:
        drive = add_sample(session)
        facts = TestFacts(0.0, label=label)
        add_bytes(session, store.files, drive, b"a", facts, name="a.xlsx.gz")
        assert export_drive(session, store.files, drive, tmp_path / "out") == 1


def test_a_label_is_taken_once(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        add_bytes(session, store.files, drive, b"a", TestFacts(0.0, label="t01"))
        with pytest.raises(BadInputError, match="another record"):
            add_bytes(session, store.files, drive, b"b", TestFacts(0.0, label="t01"))


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("../../etc/passwd", "passwd"),
        ("C:\\logs\\t01.csv", "t01.csv"),
        ("a\x00b\n.csv", "ab.csv"),
        ("\u202egnp.csv", "gnp.csv"),
        ("", "record"),
        ("x" * 400, "x" * 200),
    ],
)
def test_names_of_files_are_for_reading_only(name: str, shown: str) -> None:
    assert readable_name(name) == shown


def test_tests_of_one_name_in_the_same_instant_are_both_kept(store: Store) -> None:
    """As a program does that uploads the month's test of every drive."""
    facts = TestFacts(service_hours=1.0, label="t01")
    with store.writing() as session:
        for name in ("one", "two"):
            add_sample(session, name)

    def upload(name: str) -> str:
        with store.writing() as session:
            drive = find_drive(session, name, alone=True)
            assert drive is not None
            return add_bytes(session, store.files, drive, b"2", facts)[0].uid

    with ThreadPoolExecutor(1) as other:
        with store.writing() as session:
            drive = find_drive(session, "one", alone=True)
            assert drive is not None
            first, _ = add_bytes(session, store.files, drive, b"1", facts)
            session.flush()
            second = other.submit(upload, "two")
            with pytest.raises(TimeoutError):
                second.result(0.5)
        assert first.uid == "t01"
        assert second.result() != "t01"
    with store.reading() as session:
        for uid, name in (("t01", "one"), (second.result(), "two")):
            test = find_test(session, uid)
            assert test is not None
            assert (test.label, test.drive.name, test.service_hours) == ("t01", name, 1.0)


def test_the_trail_tells_what_a_correction_changed(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        test, _ = add_bytes(session, store.files, drive, b"a", TestFacts(900.0, note="cold"))
        accept(session, COMMAND_LINE, test, TestFacts(9000.0, tested_on=date(2026, 3, 9)))
    with store.reading() as session:
        line = trail(session)[0]
    assert (line.action, line.subject) == ("test changed", f"{drive.name} / {test.label}")
    assert line.details == {
        "before": {"service_hours": 900.0, "note": "cold"},
        "after": {"service_hours": 9000.0, "tested_on": "2026-03-09"},
    }
