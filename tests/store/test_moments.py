"""Moments come out of the store in UTC, which pages say of them."""

from __future__ import annotations

from datetime import UTC, timedelta

import pytest
from sqlalchemy import select

from hdprog.store.database import Database
from hdprog.store.tables import UserRow
from hdprog.store.tables.base import now


@pytest.mark.postgres
def test_a_server_of_postgresql_in_another_zone_answers_in_utc(postgres_url: str) -> None:
    database = Database(f"{postgres_url}?options=-c%20timezone%3DAsia/Tokyo")
    database.upgrade()
    with database.writing() as session:
        session.add(UserRow(name="ada", password_hash="", role="viewer"))
    with database.reading() as session:
        assert session.connection().exec_driver_sql("SHOW timezone").scalar() == "Asia/Tokyo"
        made = session.scalars(select(UserRow)).one().created_at
    database.close()
    assert made.tzinfo is UTC
    assert abs(now() - made) < timedelta(minutes=5)
