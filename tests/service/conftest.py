"""Fixtures of these tests."""

from tests.service_fixtures import database_url, postgres_server, postgres_url, store

__all__ = ["database_url", "postgres_server", "postgres_url", "store"]
