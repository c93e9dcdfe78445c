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
from sqlalchemy.exc import IntegrityError

from hdprog.errors import UsageError
from hdprog.store.database import Database
from hdprog.store.tables import SettingRow, TestRow

MARK = "store-id"
_NAME = "store id"
_TRIES, _TRY_SECONDS = 100, 0.1


def require_same_store(database: Database, folder: Path) -> None:
    """Mark a new pair of folder and database, and refuse two that are not a pair.

    Raises
    ------
    UsageError
        for a folder that is another store's, or none, and for a new database beside a folder that
        holds records
    """
    known = _known(database)
    path = folder / MARK
    if known is None:
        _refuse_new_beside_records(database, folder)
        with suppress(FileExistsError), path.open("x", encoding="ascii") as file:
            file.write(secrets.token_hex(16) + "\n")
        known = _keep(database, _read(path))
    if _read(path) != known:
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
    with database.reading() as session:
        known = session.get(SettingRow, _NAME), session.scalar(select(TestRow.id).limit(1))
    if known == (None, None):
        raise UsageError(
            f"--database: found a new database and {folder} with records or results of another, "
            "expected the database that the folder was begun with. Correct the address (or "
            "HDPROG_DATABASE); for a new database give an empty folder with --data."
        )


def _known(database: Database) -> str | None:
    with database.reading() as session:
        row = session.get(SettingRow, _NAME)
        return None if row is None else str(row.value["hex"])


def _keep(database: Database, mark: str) -> str:
    """Keep the mark, unless another process was first; gives the one that counts."""
    with suppress(IntegrityError), database.writing() as session:
        session.add(SettingRow(name=_NAME, value={"hex": mark}))
    return _known(database) or mark


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
