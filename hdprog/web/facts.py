"""What a form says of a test."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import date, timedelta
from inspect import signature
from typing import Annotated

from fastapi import Form

from hdprog.data.tests_table import RANGES
from hdprog.errors import BadInputError
from hdprog.store.tables.base import now
from hdprog.store.uploads import TestFacts
from hdprog.web.numbers import number_of

_MOST_NOTE = 2000  # characters
_AHEAD = timedelta(days=1)  # of the server's day in UTC: a zone east of it, a clock that is fast


def facts_of_form(
    service_hours: Annotated[
        str, Form(description="Hours in service when the test was made, a number from zero up.")
    ] = "",
    event: Annotated[
        str, Form(description="Empty, or regreased, reassembled or replaced before this test.")
    ] = "",
    test_id: Annotated[str, Form(description="Name in the drive; made where it is empty.")] = "",
    date: Annotated[str, Form(description="Day of the test, as 2026-03-09.")] = "",
    temperature_C: Annotated[str, Form(description="Temperature of the drive.")] = "",
    note: Annotated[str, Form(max_length=_MOST_NOTE)] = "",
    mean_torque_Nm: Annotated[str, Form(description="Load since the test before.")] = "",
    mean_speed_rpm: Annotated[str, Form(description="Speed since the test before.")] = "",
) -> TestFacts:
    """Read a form.

    Raises
    ------
    BadInputError
        naming the field
    """
    return read_facts(
        {
            "service_hours": service_hours,
            "event": event,
            "test_id": test_id,
            "date": date,
            "temperature_C": temperature_C,
            "note": note,
            "mean_torque_Nm": mean_torque_Nm,
            "mean_speed_rpm": mean_speed_rpm,
        }
    )


def read_facts(texts: Mapping[str, str]) -> TestFacts:
    """Read the fields of a form as texts; an empty one says nothing.

    Raises
    ------
    BadInputError
        naming the field
    """
    given = {name: text.strip() for name, text in texts.items()}
    hours = _number(given, "service_hours")
    if hours is None:
        raise BadInputError(
            "no service hours",
            "field service_hours",
            "hours in service when the test was made",
            "Fill it in; a new drive has 0.",
        )
    facts = TestFacts(
        service_hours=hours,
        label=given.get("test_id") or None,
        tested_on=_day(given.get("date", "")),
        temperature_C=_number(given, "temperature_C"),
        note=_note(given.get("note", "")),
        event=given.get("event") or None,
        mean_torque_Nm=_number(given, "mean_torque_Nm"),
        mean_speed_rpm=_number(given, "mean_speed_rpm"),
    )
    facts.check()
    return facts


FIELDS = tuple(signature(facts_of_form).parameters)
"""Names of a form's fields."""


def _note(text: str) -> str | None:
    if len(text) > _MOST_NOTE:
        raise BadInputError(
            f"a note of {len(text)} characters",
            "field note",
            f"{_MOST_NOTE} at most",
            "Shorten it; what is longer belongs beside the record.",
        )
    return text or None


def _number(given: Mapping[str, str], name: str) -> float | None:
    text = given.get(name, "")
    if not text:
        return None
    try:
        value = number_of(text, f"field {name}")
    except ValueError:
        value = math.nan
    least, most = RANGES[name]
    if not least <= value <= most:
        raise BadInputError(
            f"{name} = {text[:40]!r}",
            f"field {name}",
            f"a number from {least:g} to {most:.0f}",
            "Correct it.",
        )
    return value


def _day(text: str) -> date | None:
    if not text:
        return None
    try:
        day = date.fromisoformat(text)
    except ValueError:
        raise BadInputError(
            f"date = {text[:40]!r}",
            "field date",
            "a day in ISO 8601, like 2026-03-09",
            "Write year, month and day in this order.",
        ) from None
    today = now().date()
    if day > today + _AHEAD:
        raise BadInputError(
            f"date = {day}, a day to come",
            "field date",
            f"the day on which the test was made, {today + _AHEAD} at the latest",
            "Correct it. If it is right, the server's clock is slow: leave the field empty, and "
            "tell whoever runs the server.",
        )
    return day
