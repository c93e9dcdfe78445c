"""A folder and a database that do not belong together are refused."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from sqlalchemy import delete

from hdprog.errors import UsageError
from hdprog.store.database import Database
from hdprog.store.identity import MARK
from hdprog.store.store import Store, open_store
from hdprog.store.tables import SettingRow
from hdprog.store.uploads import TestFacts
from tests.store.samples import add_bytes, add_sample


def test_a_folder_that_is_not_mounted_is_refused(store: Store, tmp_path: Path) -> None:
    url = store.database.url
    with (
        pytest.raises(UsageError, match="Is the network folder mounted"),
        open_store(tmp_path / "empty", url),
    ):
        pass
    assert not (tmp_path / "empty" / MARK).exists()
    with open_store(store.files.root, url):
        pass


def test_another_stores_folder_is_refused(store: Store, tmp_path: Path) -> None:
    with open_store(tmp_path / "other"):
        pass
    with (
        pytest.raises(UsageError, match="another mark"),
        open_store(tmp_path / "other", store.database.url),
    ):
        pass


def test_a_new_database_takes_on_the_folder_it_is_given(store: Store, tmp_path: Path) -> None:
    mark = (store.files.root / MARK).read_text("ascii")
    with open_store(store.files.root, f"sqlite:///{tmp_path / 'new.db'}"):
        pass
    assert (store.files.root / MARK).read_text("ascii") == mark


def test_a_database_that_is_refused_keeps_its_tables(store: Store, tmp_path: Path) -> None:
    """They were brought up to date first: the older program that they belong to then refused."""
    store.database.downgrade("0002")
    (tmp_path / "full" / "raw" / "one").mkdir(parents=True)
    slip = Database(f"sqlite:///{tmp_path / 'slip.db'}")
    for data, url in (("empty", store.database.url), ("full", slip.url)):
        with pytest.raises(UsageError), open_store(tmp_path / data, url):
            pass
    assert store.database.revision() == "0002"
    assert not slip.has_tables()
    slip.close()


@pytest.mark.parametrize("kept", ["raw", "analyses"])
def test_a_new_database_beside_records_is_refused(store: Store, tmp_path: Path, kept: str) -> None:
    """An address with a slip was taken for a new store's, and all old results were tidied away."""
    (store.files.root / kept / "one").mkdir()
    slip = f"sqlite:///{tmp_path / 'slip.db'}"
    with pytest.raises(UsageError, match="a new database and"), open_store(store.files.root, slip):
        pass
    with open_store(store.files.root, store.database.url):
        pass


def test_a_database_of_before_the_mark_keeps_its_folder(store: Store) -> None:
    with store.writing() as session:
        drive = add_sample(session)
        add_bytes(session, store.files, drive, b"record", TestFacts(1.0))
        session.execute(delete(SettingRow))
    (store.files.root / MARK).unlink()
    with open_store(store.files.root, store.database.url):
        pass
    assert (store.files.root / MARK).exists()


@pytest.mark.skipif(os.name != "posix", reason="no such permissions")
def test_the_database_is_its_owners_alone_in_a_folder_that_was_there_before(tmp_path: Path) -> None:
    """Anybody on the machine could read the hashes of passwords."""
    tmp_path.chmod(0o755)
    before = os.umask(0o022)
    try:
        with open_store(tmp_path) as store, store.writing() as session:
            add_sample(session)
            session.flush()
            modes = {path.name: path.stat().st_mode & 0o777 for path in tmp_path.glob("hdprog.db*")}
    finally:
        os.umask(before)
    assert modes == dict.fromkeys(("hdprog.db", "hdprog.db-wal", "hdprog.db-shm"), 0o600)
