"""What is said of a test on a page: what cannot be is refused in words."""

from __future__ import annotations

from datetime import UTC, date, datetime

import pytest

from hdprog.errors import BadInputError
from hdprog.web import facts


@pytest.fixture(autouse=True)
def late_in_the_year(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(facts, "now", lambda: datetime(2026, 12, 31, 23, 30, tzinfo=UTC))


@pytest.mark.parametrize("day", ["2026-12-31", "2027-01-01"])  # the second is today in the east
def test_a_day_that_has_come_somewhere_is_taken(day: str) -> None:
    read = facts.read_facts({"service_hours": "1", "date": day})
    assert read.tested_on == date.fromisoformat(day)


@pytest.mark.parametrize("day", ["2027-01-02", "2062-03-09", "9999-12-31"])
def test_a_day_to_come_is_refused(day: str) -> None:
    with pytest.raises(BadInputError, match=f"{day}, a day to come; expected .* at the latest"):
        facts.read_facts({"service_hours": "1", "date": day})


def test_a_note_is_no_longer_than_its_field_takes() -> None:
    read = facts.read_facts({"service_hours": "1", "note": "a" * 2000})
    assert read.note == "a" * 2000
    with pytest.raises(BadInputError, match="found a note of 2001 characters"):
        facts.read_facts({"service_hours": "1", "note": "a" * 2001})
