"""Does this folder belong to this database? A mark in both says so.

A worker on another machine whose network folder is not mounted would find an empty one, and so
would a server that was given the wrong address: neither may take in or judge anything then.
"""

from __future__ import annotations

import secrets
import time
from contextlib import suppress
from pathlib import Path

from sqlalchemy import select

from hdprog.errors import UsageError
from hdprog.store.database import Database
from hdprog.store.settings import held_setting
from hdprog.store.tables import SettingRow, TestRow

MARK = "store-id"
_NAME = "store id"
_TRIES, _TRY_SECONDS = 100, 0.1


def begin_store(database: Database, folder: Path) -> None:
    """Mark a new pair of folder and database, and refuse two that are not a pair.

    Raises
    ------
    UsageError
        as `refuse_another_store`
    """
    refuse_another_store(database, folder)
    if _known(database) is None:
        with suppress(FileExistsError), (folder / MARK).open("x", encoding="ascii") as file:
            file.write(secrets.token_hex(16) + "\n")
        mark = _read(folder / MARK)  # first: another process may be about to write it
        with database.writing() as session:
            held_setting(session, _NAME, {"hex": mark})
        refuse_another_store(database, folder)


def refuse_another_store(database: Database, folder: Path) -> None:
    """Refuse a folder and a database that are not a pair; nothing of either is changed.

    Raises
    ------
    UsageError
        for a folder that is another store's, or none, and for a new database beside a folder that
        holds records
    """
    known, path = _known(database), folder / MARK
    if known is None:
        _refuse_new_beside_records(database, folder)
    elif _read(path) != known:
        found = "another mark than the database has" if path.exists() else "no mark of a store"
        raise UsageError(
            f"--data: found {found} in {folder}, expected the folder that this database was begun "
            "with. Is the network folder mounted, and is --database the right one?"
        )


def _refuse_new_beside_records(database: Database, folder: Path) -> None:
    """Refuse a database that knows nothing of what lies in the folder.

    Results that no database knows are tidied up: an address with a slip in it would cost them all.
    """
    if not any(any((folder / name).iterdir()) for name in ("raw", "analyses")):
        return
    # Looked up after the folder: of two programs that begin a store the other may have been first.
    if _known(database) is None and not _has_tests(database):
        raise UsageError(
            f"--database: found a new database and {folder} with records or results of another, "
            "expected the database that the folder was begun with. Correct the address (or "
            "HDPROG_DATABASE); for a new database give an empty folder with --data."
        )


def _known(database: Database) -> str | None:
    if not database.has_tables():
        return None
    with database.reading() as session:
        row = session.get(SettingRow, _NAME)
        return None if row is None else str(row.value["hex"])


def _has_tests(database: Database) -> bool:
    if not database.has_tables():
        return False
    with database.reading() as session:
        return session.scalar(select(TestRow.id).limit(1)) is not None


def _read(path: Path) -> str:
    """Read a folder's mark; empty where it has none."""
    for _ in range(_TRIES):
        try:
            found = path.read_text("ascii")
        except FileNotFoundError:
            return ""
        if found.endswith("\n"):
            return found.strip()
        time.sleep(_TRY_SECONDS)  # another process is about to write it
    return ""
