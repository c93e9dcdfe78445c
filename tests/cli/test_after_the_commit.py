"""What a command says that it did is in the database by then; a database without room is told."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, event
from sqlalchemy.orm import Session
from typer.testing import CliRunner, Result

from hdprog.cli import app
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
