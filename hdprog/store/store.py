"""The store as a whole: its database and its folder of files, opened together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hdprog.errors import UsageError, no_room
from hdprog.store.database import Database, is_known, newest_revision, trouble_with
from hdprog.store.files import Files
from hdprog.store.identity import begin_store, refuse_another_store


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
        """Make or bring up to date the tables; a database that is refused stays as it is.

        Raises
        ------
        UsageError
            for a database that does not answer, that a newer version of the program or another
            program has made, or whose records lie in another folder
        """
        trouble = trouble_with(self.database)
        if trouble is not None and no_room(trouble):
            raise trouble
        if trouble is not None:
            words = getattr(trouble, "orig", trouble)
            raise UsageError(
                f"--database: found no answer ({words}), expected a database that takes "
                "connections. Start it, or correct the address."
            )
        made = self.database.has_tables()  # before the revision, which comes with them
        found = self.database.revision()
        if found is None and made:
            raise UsageError(
                "--database: found tables of another program with the names of hdprog's, expected "
                "an empty database or one of hdprog. Correct the address, or make a database for "
                "hdprog alone."
            )
        if found is not None and not is_known(found):
            raise UsageError(
                f"--database: found tables of revision {found}, expected {newest_revision()} at "
                "most: a newer hdprog or another program has made them. Install that version, go "
                "back to a backup, or correct the address."
            )
        refuse_another_store(self.database, self.files.root)
        self.database.upgrade()
        begin_store(self.database, self.files.root)

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
