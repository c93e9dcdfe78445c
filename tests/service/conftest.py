"""Fixtures of these tests."""

from tests.service_fixtures import (
    database_url,
    postgres_server,
    postgres_url,
    sqlite_store,
    store,
)

__all__ = ["database_url", "postgres_server", "postgres_url", "sqlite_store", "store"]
