"""A read-out belongs to the settings that its record was read with."""

from __future__ import annotations

from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import change_drive, content_of
from hdprog.store.readings import is_current, with_problems, with_reading
from hdprog.store.store import Store
from hdprog.store.uploads import TestFacts
from tests.store.samples import add_bytes, add_sample, content

COLUMNS = {"columns": {"torque": "T:Nm"}}


def test_columns_and_rows_make_a_read_out_old_and_nothing_else_does() -> None:
    quality = with_reading({"samples": 3}, content() | COLUMNS)
    assert is_current(quality, content(rated_torque_Nm=50.0) | COLUMNS)
    assert not is_current(quality, content())
    assert not is_current(quality, content() | COLUMNS | {"select": {"cycle": [2]}})


def test_read_outs_of_earlier_versions_are_old_once_columns_change(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        test, _ = add_bytes(session, store.files, drive, b"a", TestFacts(0.0))
        assert is_current(test.quality, content_of(drive))
        change_drive(session, COMMAND_LINE, drive, content(ratio=80.0))
        assert is_current(test.quality, content_of(drive))
        change_drive(session, COMMAND_LINE, drive, content() | COLUMNS)
        assert not is_current(test.quality, content_of(drive))
        change_drive(session, COMMAND_LINE, drive, content())
        assert is_current(test.quality, content_of(drive))


def test_what_earlier_settings_could_not_read_is_no_word_about_later_ones(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        test, _ = add_bytes(session, store.files, drive, b"a", TestFacts(0.0))
        change_drive(session, COMMAND_LINE, drive, content() | COLUMNS)
        test.quality = with_problems(test.quality, ["a.csv: found no column 'T'"])
        change_drive(session, COMMAND_LINE, drive, content())
        assert "unreadable" not in test.quality
