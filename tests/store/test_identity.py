"""A folder and a database that do not belong together are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from hdprog.errors import UsageError
from hdprog.store.identity import MARK
from hdprog.store.store import Store, open_store


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
