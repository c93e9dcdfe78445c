"""Places of workers: each is held by a lock that goes when its worker dies, however it dies."""

from __future__ import annotations

import hashlib
import re
import socket
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Protocol

from filelock import FileLock, Timeout
from sqlalchemy import Connection, Engine, NullPool, create_engine, text
from sqlalchemy.exc import DBAPIError

from hdprog.store.database import sqlite_file
from hdprog.store.store import Store

_MOST = 512
# A machine that lost its power closes no connection: its place is free after half a minute of
# silence, and its own side, should it still be there, knows after the same time.
_SILENCE = {"keepalives_idle": 15, "keepalives_interval": 5, "keepalives_count": 3}
_SILENCE_MS = 30_000


class Hold(Protocol):
    """A place that is held."""

    def lost(self) -> bool:
        """Tell whether somebody else holds it by now."""


class Places(Protocol):
    """Where places are held."""

    def hold(self, name: str) -> AbstractContextManager[Hold | None]:
        """Hold a place for a block; gives None where a living worker has it."""


def places_of(store: Store) -> Places:
    """Choose who keeps the places.

    SQLite is for one machine, whose file locks can be relied on. Workers of PostgreSQL may stand on
    several, and locks of files over a network cannot: there the database keeps them.
    """
    if sqlite_file(store.database.url) is not None:
        return FilePlaces(store.files.workers)
    return DatabasePlaces(store.database.url)


@contextmanager
def taken_slot(places: Places) -> Iterator[tuple[str, Hold]]:
    """Take the first free place of this machine for the block; gives its name and the hold on it.

    A worker that starts again takes the place, and so the work, of the one that was killed.
    """
    host = re.sub(r"[^A-Za-z0-9-]", "-", socket.gethostname())[:40] or "worker"
    for number in range(1, _MOST + 1):
        name = f"{host}-{number}"
        with places.hold(name) as hold:
            if hold is not None:
                yield name, hold
                return
    raise RuntimeError(f"more than {_MOST} workers on one machine")


class FilePlaces:
    """Places held by locks of files, which this machine frees when a process dies.

    Parameters
    ----------
    folder : for the files
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    @contextmanager
    def hold(self, name: str) -> Iterator[Hold | None]:
        """Hold a place for the block; gives None where a living worker has it."""
        lock = FileLock(self._folder / f"{name}.lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            yield None
            return
        try:
            yield _FileHold()
        finally:
            lock.release()


class _FileHold:
    def lost(self) -> bool:
        """Say no: a process keeps the locks of its files."""
        return False


class DatabasePlaces:
    """Places held by advisory locks of PostgreSQL, which go when a worker's connection ends.

    Parameters
    ----------
    url : address of the database; a pooler of transactions cannot stand in for it
    """

    def __init__(self, url: str) -> None:
        server = " ".join(f"-c tcp_{name}={value}" for name, value in _SILENCE.items())
        self._engine = create_engine(
            url,
            poolclass=NullPool,
            isolation_level="AUTOCOMMIT",
            connect_args={**_SILENCE, "tcp_user_timeout": _SILENCE_MS, "options": server},
        )

    @contextmanager
    def hold(self, name: str) -> Iterator[Hold | None]:
        """Hold a place for the block; gives None where a living worker has it."""
        hold = _DatabaseHold(self._engine, name)
        try:
            yield hold if hold.take() else None
        finally:
            hold.close()


class _DatabaseHold:
    """A connection that has the lock of a place, or had it when last looked at."""

    def __init__(self, engine: Engine, name: str) -> None:
        self._engine, self._key = engine, _key(name)
        self._connection: Connection | None = None

    def take(self) -> bool:
        """Connect and take the lock; tells whether it was free."""
        self._connection = self._engine.connect()
        asked = text("SELECT pg_try_advisory_lock(:key)")
        return bool(self._connection.scalar(asked, {"key": self._key}))

    def lost(self) -> bool:
        """Tell whether another has the place; one that only lost its connection is taken again.

        While the database is away nothing is known, and nobody else can take anything over. Who was
        cut off alone may find the place free again and the job gone: its attempt no longer counts.
        """
        try:
            if self._connection is not None:
                self._connection.exec_driver_sql("SELECT 1")
                return False
        except DBAPIError:
            self.close()
        try:
            return not self.take()
        except DBAPIError:
            self.close()
            return False

    def close(self) -> None:
        """Give the lock back with the connection."""
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.close()


def _key(name: str) -> int:
    digest = hashlib.sha256(f"hdprog worker {name}".encode()).digest()
    return int.from_bytes(digest[:8], "big", signed=True)
