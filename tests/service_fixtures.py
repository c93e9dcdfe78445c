"""Fixtures of the tests of store, service and pages: databases of both kinds, stores in them."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest

from hdprog.store.store import Store
from tests.store.postgres import programs, running


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[str]:
    """Run one PostgreSQL server for all tests that want it."""
    binaries = programs()
    if binaries is None:
        pytest.skip("no PostgreSQL: neither /usr/lib/postgresql/*/bin nor initdb on PATH")
    with running(binaries) as address:
        yield address


@pytest.fixture
def postgres_url(postgres_server: str) -> str:
    """Make an empty database in it."""
    import psycopg

    name = f"t{uuid.uuid4().hex}"
    with psycopg.connect(postgres_server, autocommit=True) as connection:
        connection.execute(f"CREATE DATABASE {name}".encode())
    return postgres_server.replace("/postgres", f"/{name}")


@pytest.fixture(params=["sqlite", pytest.param("postgres", marks=pytest.mark.postgres)])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Give the address of an empty database, of each kind in turn."""
    if request.param == "postgres":
        return str(request.getfixturevalue("postgres_url"))
    return f"sqlite:///{tmp_path / 'test.db'}"


@pytest.fixture
def sqlite_store(tmp_path: Path) -> Iterator[Store]:
    """Open a store in SQLite, for what takes long and depends on the service alone."""
    opened = Store(tmp_path / "data")
    opened.prepare()
    yield opened
    opened.close()


@pytest.fixture
def store(database_url: str, tmp_path: Path) -> Iterator[Store]:
    """Open a store in it."""
    opened = Store(tmp_path / "data", database_url)
    opened.prepare()
    yield opened
    opened.close()
