"""The tables come and go by their steps, on both databases, and match what the program expects."""

from __future__ import annotations

import multiprocessing
from multiprocessing.synchronize import Barrier
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import inspect

from hdprog.errors import UsageError
from hdprog.store.database import Database, newest_revision, normalised
from hdprog.store.store import Store
from hdprog.store.tables import Base


def tables_of(database: Database) -> set[str]:
    return set(inspect(database.engine).get_table_names()) - {"alembic_version"}


def test_up_down_and_up_again(database_url: str) -> None:
    database = Database(database_url)
    assert database.revision() is None
    database.upgrade()
    assert database.revision() == newest_revision()
    assert tables_of(database) == set(Base.metadata.tables)
    database.downgrade("base")
    assert database.revision() is None
    assert tables_of(database) == set()
    database.upgrade()
    assert tables_of(database) == set(Base.metadata.tables)
    database.close()


def test_the_steps_make_the_tables_that_the_program_expects(database_url: str) -> None:
    database = Database(database_url)
    database.upgrade()
    with database.engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, Base.metadata) == []
    database.close()


def test_tables_of_a_newer_program_are_left_alone(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.prepare()
    with store.database.engine.begin() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    with pytest.raises(UsageError, match="newer hdprog"):
        store.prepare()
    store.close()


@pytest.mark.parametrize("address", ["nonsense", "mysql://host/name"])
def test_other_databases_are_refused(address: str) -> None:
    with pytest.raises(UsageError, match="--database: found"):
        normalised(address)


def test_a_database_that_does_not_answer_is_said_so(tmp_path: Path) -> None:
    store = Store(tmp_path, "postgresql://nobody@127.0.0.1:1/none")
    with pytest.raises(UsageError, match="no answer"):
        store.prepare()


def begin(url: str, ready: Barrier) -> None:
    """Make the tables as soon as all others are about to."""
    database = Database(url)
    ready.wait(60.0)
    database.upgrade()
    assert database.revision() == newest_revision()
    database.close()


def test_programs_that_start_together_make_the_tables_once(database_url: str) -> None:
    spawn, count = multiprocessing.get_context("spawn"), 3
    ready = spawn.Barrier(count)
    programs = [spawn.Process(target=begin, args=(database_url, ready)) for _ in range(count)]
    for program in programs:
        program.start()
    for program in programs:
        program.join(120.0)
    assert [program.exitcode for program in programs] == [0] * count
