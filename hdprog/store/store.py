"""The store as a whole: its database and its folder of files, opened together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hdprog.errors import UsageError
from hdprog.store.database import Database, newest_revision, reachable
from hdprog.store.files import Files
from hdprog.store.identity import require_same_store


class Store:
    """A store that is open.

    Attributes
    ----------
    files : the data folder
    database : connections to the database
    """

    def __init__(self, data: Path, url: str | None = None) -> None:
        self.files = Files(data)
        self.database = Database(url or self.files.database_url)
        self.reading, self.writing = self.database.reading, self.database.writing

    def prepare(self) -> None:
        """Make or bring up to date the tables.

        Raises
        ------
        UsageError
            for a database that does not answer, that a newer version of the program has made, or
            whose records lie in another folder
        """
        trouble = reachable(self.database)
        if trouble is not None:
            raise UsageError(
                f"--database: found no answer ({trouble}), expected a database that takes "
                "connections. Start it, or correct the address."
            )
        found = self.database.revision()
        if found is not None and found > newest_revision():
            raise UsageError(
                f"--database: found tables of revision {found}, expected {newest_revision()} at "
                "most: a newer hdprog has made them. Install that version, or go back to a backup."
            )
        self.database.upgrade()
        require_same_store(self.database, self.files.root)

    def close(self) -> None:
        """Close all connections."""
        self.database.close()


@contextmanager
def open_store(data: Path, url: str | None = None) -> Iterator[Store]:
    """Open a store, its tables up to date, for the block."""
    store = Store(data, url)
    try:
        store.prepare()
        yield store
    finally:
        store.close()
