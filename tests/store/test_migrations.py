"""The tables come and go by their steps, on both databases, and match what the program expects."""

from __future__ import annotations

import multiprocessing
from datetime import UTC, datetime
from multiprocessing.synchronize import Barrier
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import MetaData, event, insert, inspect, select

from hdprog.errors import UsageError
from hdprog.store.database import Database, newest_revision, normalised
from hdprog.store.store import Store
from hdprog.store.tables import Base, ForecastRow


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


def test_forecasts_of_an_older_program_are_kept_and_have_no_horizon(database_url: str) -> None:
    database = Database(database_url)
    database.upgrade("0002")
    made = datetime(2026, 3, 9, tzinfo=UTC)
    old = MetaData()
    with database.engine.begin() as connection:
        old.reflect(connection)
        drive = dict.fromkeys(("settings", "remaining", "sparkline"), "{}")
        drive |= dict.fromkeys(("rank", "rank_hours", "warnings", "tests", "id"), 1)
        drive |= dict.fromkeys(("name", "created_by", "status", "label", "sentence"), "one")
        drive |= {"created_at": made, "provisional": False}
        analysis = {"id": "a", "drive_id": 1, "created_at": made, "hdprog_version": "0"}
        analysis |= {"quick": False, "converged": True, "status": "plan", "verdict": ""}
        forecast = {"id": 1, "analysis_id": "a", "position": 0, "quantity": "first_limit"}
        forecast |= {"now_hours": 900.0, "already_crossed": False, "inspect_before_hours": 1310.0}
        forecast |= {"remaining_hours": {"q05": 410.0}}
        for table, row in (("drives", drive), ("analyses", analysis), ("forecasts", forecast)):
            connection.execute(insert(old.tables[table]).values(**row))
    for _ in range(2):
        database.upgrade()
        with database.reading() as session:
            [kept] = session.scalars(select(ForecastRow)).all()
            assert kept.horizon_hours is None
            assert (kept.inspect_before_hours, kept.remaining_hours) == (1310.0, {"q05": 410.0})
        database.downgrade("0002")
    columns = inspect(database.engine).get_columns("forecasts")
    assert "horizon_hours" not in {column["name"] for column in columns}
    database.close()


@pytest.mark.parametrize("revision", ["9999", "00ab12"])
def test_tables_of_a_newer_program_are_left_alone(tmp_path: Path, revision: str) -> None:
    store = Store(tmp_path)
    store.prepare()
    with store.database.engine.begin() as connection:
        connection.exec_driver_sql(f"UPDATE alembic_version SET version_num = '{revision}'")
    with pytest.raises(UsageError, match="newer hdprog or another program"):
        store.prepare()
    store.close()


def test_a_database_with_tables_of_another_program_is_refused(store: Store) -> None:
    """It ended as a mistake of the program."""
    with store.database.engine.begin() as connection:
        connection.exec_driver_sql("DROP TABLE alembic_version")
    with pytest.raises(UsageError, match="found tables of another program"):
        store.prepare()


@pytest.mark.parametrize(
    "address", ["nonsense", "mysql://host/name", "sqlite://", "sqlite:///:memory:"]
)
def test_other_databases_are_refused(address: str) -> None:
    """One in memory took accounts and records, and ended with the command."""
    with pytest.raises(UsageError, match="--database: found"):
        normalised(address)


def test_a_database_that_does_not_answer_is_said_so(tmp_path: Path) -> None:
    store = Store(tmp_path, "postgresql://nobody@127.0.0.1:1/none")
    with pytest.raises(UsageError, match="no answer"):
        store.prepare()


def test_an_upgrade_that_breaks_off_leaves_the_tables_as_they_were(database_url: str) -> None:
    """SQLite was let go of after each step: programs that started together came between."""
    database = Database(database_url)

    def break_off(_connection: object, _cursor: object, statement: str, *_rest: object) -> None:
        if "horizon_hours" in statement:
            raise KeyboardInterrupt

    event.listen(database.engine, "before_cursor_execute", break_off)
    with pytest.raises(KeyboardInterrupt):
        database.upgrade()
    event.remove(database.engine, "before_cursor_execute", break_off)
    assert database.revision() is None
    assert tables_of(database) == set()
    database.upgrade()
    assert database.revision() == newest_revision()
    database.close()


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
