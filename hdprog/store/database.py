"""The database: SQLite beside the files by default, PostgreSQL by its address."""

from __future__ import annotations

import logging
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, Engine, create_engine, event, inspect, make_url
from sqlalchemy.exc import ArgumentError, OperationalError, SQLAlchemyError
from sqlalchemy.orm import Session, sessionmaker

from hdprog.errors import UsageError
from hdprog.store.tables import Base

log = logging.getLogger("hdprog.store")
_Found = TypeVar("_Found")
_AGAIN_SECONDS = 1.0
_WAIT_SECONDS = 30.0  # for another writer, before a write fails
_CONNECTIONS = 20
_WRITES = "hdprog_writes"
_UPGRADES = 0x6864_7072_6F67  # "hdprog": the lock of whoever changes the tables


class Database:
    """Connections to the store's database.

    Parameters
    ----------
    url : address as SQLAlchemy takes it, ``sqlite:///…`` or ``postgresql://…``

    Raises
    ------
    UsageError
        for an address of anything else
    """

    def __init__(self, url: str) -> None:
        self.url = normalised(url)
        self.engine = _engine(self.url)
        self._readers = sessionmaker(self.engine, expire_on_commit=False)
        self._writer = self.engine.execution_options(**{_WRITES: True})
        self._writers = sessionmaker(self._writer, expire_on_commit=False)

    @contextmanager
    def reading(self) -> Iterator[Session]:
        """Give a session for looking up."""
        with self._readers() as session:
            yield session

    @contextmanager
    def writing(self) -> Iterator[Session]:
        """Give a session whose changes are kept when the block ends without an error."""
        with self._writers.begin() as session:
            yield session

    def upgrade(self, to: str = "head") -> None:
        """Bring the tables to a revision, the newest unless another is named.

        Of programs that start together one makes the tables, the others wait for it. What breaks
        off leaves the tables as they were: all steps are one transaction.
        """
        # Begun here: of its own accord Alembic lets go of SQLite after each step.
        with self._writer.begin() as connection:
            if connection.dialect.name == "postgresql":
                connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_UPGRADES})")
            command.upgrade(_alembic(connection), to)

    def downgrade(self, to: str) -> None:
        """Take the tables back to an earlier revision ("base" leaves none)."""
        with self._writer.begin() as connection:
            command.downgrade(_alembic(connection), to)

    def revision(self) -> str | None:
        """Say which revision the tables have; None before the first."""
        with self.engine.connect() as connection:
            return MigrationContext.configure(connection).get_current_revision()

    def has_tables(self) -> bool:
        """Tell whether tables of the program's names are there, whoever made them."""
        return bool(set(inspect(self.engine).get_table_names()) & set(Base.metadata.tables))

    def close(self) -> None:
        """Close all connections."""
        self.engine.dispose()


def newest_revision() -> str:
    """Name the revision that this version of the program needs."""
    head = ScriptDirectory.from_config(_alembic(None)).get_current_head()
    assert head is not None
    return head


def is_known(revision: str) -> bool:
    """Tell whether this version of the program can start from tables of a revision."""
    steps = ScriptDirectory.from_config(_alembic(None)).walk_revisions()
    return revision in {step.revision for step in steps}


def normalised(url: str) -> str:
    """Give a database's address with the driver that the extra `postgres` installs.

    Raises
    ------
    UsageError
        for what is no address, a database other than SQLite and PostgreSQL, or one in memory alone
    """
    try:
        parsed = make_url(url)
    except ArgumentError as error:
        raise UsageError(
            f"--database: found {url!r}, expected an address such as "
            "postgresql://user:password@host/name or sqlite:////path/to/file.db"
        ) from error
    kind = parsed.get_backend_name()
    if kind == "postgresql":
        parsed = parsed.set(drivername="postgresql+psycopg")
    elif kind != "sqlite":
        raise UsageError(
            f"--database: found a database of the kind {kind}, expected sqlite or postgresql. "
            "Leave --database out to keep everything in the data folder."
        )
    elif parsed.database in (None, "", ":memory:"):
        raise UsageError(
            f"--database: found {url!r}, a database in memory that ends with the command, expected "
            "one in a file, such as sqlite:////path/to/file.db. Leave --database out to keep "
            "everything in the data folder."
        )
    return parsed.render_as_string(hide_password=False)


def sqlite_file(url: str) -> Path | None:
    """Give the file of an SQLite database, None for another kind."""
    parsed = make_url(url)
    if parsed.get_backend_name() != "sqlite" or not parsed.database:
        return None
    return Path(parsed.database)


def _engine(url: str) -> Engine:
    file = sqlite_file(url)
    if file is None:
        return create_engine(url, pool_size=_CONNECTIONS, pool_pre_ping=True)
    with suppress(OSError):  # SQLite has its own words for a place where no file can be
        # For its owner alone, as -wal and -shm are then: it holds the hashes of passwords.
        file.touch(mode=0o600)
    engine = create_engine(
        url,
        pool_size=_CONNECTIONS,
        connect_args={"timeout": _WAIT_SECONDS, "check_same_thread": False},
    )

    @event.listens_for(engine, "connect")
    def prepare(connection: Any, _record: Any) -> None:
        connection.isolation_level = None  # transactions begin where `begin` says so
        _write_ahead(connection)
        connection.execute("PRAGMA synchronous=FULL")  # an accepted upload outlives a power cut
        connection.execute("PRAGMA foreign_keys=ON")

    @event.listens_for(engine, "begin")
    def begin(connection: Connection) -> None:
        # A reader that turned writer could find that another had written: writers wait first.
        writes = connection.get_execution_options().get(_WRITES, False)
        connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    return engine


def _write_ahead(connection: sqlite3.Connection) -> None:
    """Let readers and one writer work side by side.

    SQLite does not wait by itself where another program that starts meanwhile does the same.
    """
    ends = time.monotonic() + _WAIT_SECONDS
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL")
        except sqlite3.OperationalError:
            if time.monotonic() > ends:
                raise
            time.sleep(0.02)
        else:
            return


def _alembic(connection: Connection | None) -> Config:
    config = Config()
    config.set_main_option("script_location", "hdprog.store:migrations")
    config.attributes["connection"] = connection
    return config


def trouble_with(database: Database) -> SQLAlchemyError | None:
    """Give the error for which the database does not answer; None where it does."""
    try:
        with database.engine.connect() as connection:
            connection.exec_driver_sql("SELECT 1")
    except SQLAlchemyError as error:
        return error
    return None


def patiently(work: Callable[[], _Found], before_each: Callable[[], None] | None = None) -> _Found:
    """Do a piece of work on the database as soon as it answers.

    A server that is started anew must not cost hours of fitting, nor leave a job that nobody has.

    Parameters
    ----------
    work : to be done, as a whole; again from its start where the connection broke
    before_each : called before each try; an error of it makes an end
    """
    told = False
    while True:
        if before_each is not None:
            before_each()
        try:
            return work()
        except OperationalError as error:
            if not told:
                log.warning("the database does not answer, trying again: %s", error.orig)
            told = True
            time.sleep(_AGAIN_SECONDS)
