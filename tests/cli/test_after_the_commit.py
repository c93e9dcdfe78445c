"""What a command says that it did is in the database by then; a database without room is told."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import psycopg
import pytest
from sqlalchemy import Engine, event
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session
from typer.testing import CliRunner, Result

from hdprog.cli import app
from hdprog.errors import no_room
from hdprog.store.tables import AuditRow

PASSWORD = "a long enough password\n"


@contextmanager
def commits_that_fail(error: Exception) -> Iterator[None]:
    """Refuse to keep what stands in the audit trail; the tables' own upkeep goes on."""
    noted = []

    def look(session: Session, _context: Any) -> None:
        noted.extend(row for row in session.new if isinstance(row, AuditRow))

    def refuse(_connection: Any) -> None:
        if noted:
            raise error

    event.listen(Session, "after_flush", look)
    event.listen(Engine, "commit", refuse)
    try:
        yield
    finally:
        event.remove(Engine, "commit", refuse)
        event.remove(Session, "after_flush", look)


def run(data: Path, *arguments: str) -> Result:
    return CliRunner().invoke(app, [*arguments, "--data", str(data)], input=PASSWORD)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Make a store with an account and a token."""
    assert run(tmp_path, "user", "add", "ada").exit_code == 0
    assert run(tmp_path, "token", "add", "rig").exit_code == 0
    return tmp_path


@pytest.mark.parametrize(
    "command", ["user add bob", "user password ada", "token add robot", "token revoke rig"]
)
def test_nothing_is_claimed_that_was_not_kept(data: Path, command: str) -> None:
    """A token was said to be revoked, and was valid on."""
    with commits_that_fail(sqlite3.OperationalError("disk I/O error")):
        failed = run(data, *command.split())
    assert failed.exit_code != 0
    assert failed.stdout == ""
    done = run(data, *command.split())
    assert done.exit_code == 0
    assert done.stdout != ""


@pytest.mark.parametrize("command", ["user add bob", "user password ada", "token revoke rig"])
def test_a_full_disk_under_the_database_is_no_mistake_of_the_program(
    data: Path, command: str
) -> None:
    """It ended with exit code 1 and a request to report it."""
    with commits_that_fail(OperationalError("COMMIT", None, full_disk())):
        failed = run(data, *command.split())
    assert failed.exit_code == 3
    assert failed.stdout == ""
    assert "full: found no room in the store's database; expected room" in failed.stderr


def full_disk() -> sqlite3.OperationalError:
    """Give what SQLite itself raises."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.execute("PRAGMA max_page_count=1")
        with pytest.raises(sqlite3.OperationalError) as raised:
            connection.execute("CREATE TABLE one (number)")
    return raised.value


def test_a_full_disk_under_postgresql_is_known() -> None:
    raised = OperationalError("INSERT", None, psycopg.errors.DiskFull("could not extend file"))
    assert no_room(raised) == "could not extend file"
    raised = OperationalError("INSERT", None, psycopg.errors.AdminShutdown("terminating"))
    assert no_room(raised) is None
