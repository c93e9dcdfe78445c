"""A drive's page tells the dates that its report and the list tell."""

from __future__ import annotations

import hashlib
import math
import uuid
from dataclasses import replace

import pytest
from sqlalchemy import update

from hdprog.reporting.fleet_index import build_fleet_index, fleet_drive
from hdprog.reporting.forecast_words import LATER
from hdprog.reporting.rounding import date_down, hours
from hdprog.reporting.sections.remaining_life import limits_table
from hdprog.reporting.sections.table import Value
from hdprog.reporting.summary import summary_json
from hdprog.results import DriveResult
from hdprog.service.analyse import standing
from hdprog.store import analyses, jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import change_drive, content_of, find_drive
from hdprog.store.tables import ForecastRow
from hdprog.store.uploads import TestFacts, add_test
from hdprog.web.service import Service
from tests.reporting.drives import LOST_MOTION, SECANT, wearing
from tests.store.samples import add_sample
from tests.web.conftest import ClientOf, service_in
from tests.web.server import text_of

FAR = {"crossing": 17_000.0, "spread": 2_500.0}  # the late end lies past the horizon


def analysed(service: Service, result: DriveResult) -> str:
    """Put a drive with a result into a store; gives its name."""
    summary, name = summary_json(result), f"d{uuid.uuid4().hex}"
    with service.store.writing() as session:
        drive = add_sample(session, name)
        tests = [
            add_test(
                session,
                COMMAND_LINE,
                drive,
                TestFacts(one.service_hours, one.test_id),
                file_name="a.csv",
                sha256=hashlib.sha256(f"{name} {one.test_id}".encode()).hexdigest(),
                size=1,
                quality={},
                accepted=True,
            )[0]
            for one in result.tests
        ]
        job = jobs.add_job(session, COMMAND_LINE, drive, None)
        number = str(uuid.uuid4())
        analyses.record(session, job, number, tests, summary, standing(summary))
    return name


def list_of(result: DriveResult) -> dict[str, object]:
    """Give the content of a fleet's list with a drive."""
    content: dict[str, object] = dict.fromkeys(
        ("fleet", "created", "hdprog_version", "seed", "command"), "f"
    )
    drives = [fleet_drive("d", "d", summary_json(result))]
    return content | {"drives": drives, "left_out": [], "quick": False}


def section_of(page: str) -> str:
    """Give a page's words from the forecast's rows on."""
    return page[page.index("By the horizon") :]


def rows_of_report(result: DriveResult) -> list[tuple[str, str]]:
    """Give what the report says of each limit: when it is passed (90 %), inspect before."""
    found = []
    for row in limits_table(result).groups[0].rows:
        passed = row.cells[1]
        assert isinstance(passed, Value)
        words = passed.spread.replace(" to later", f" h to {LATER}")
        found.append((" ".join(words.split()), " ".join(str(row.cells[-1]).split())))
    return found


@pytest.mark.parametrize("never", [0.0, 0.3])
@pytest.mark.parametrize("far", [FAR, {}])
def test_the_page_tells_the_dates_of_the_report(
    person: ClientOf, never: float, far: dict[str, float]
) -> None:
    result = wearing(LOST_MOTION, SECANT, never=never, **far)
    viewer = person("viewer")
    page = text_of(viewer.get(f"/drives/{analysed(service_in(viewer), result)}").text)
    told = rows_of_report(result)
    assert len(told) == 3
    for passed, before in told:
        assert passed in page
        assert f" {before} " in page


def test_the_page_tells_the_date_of_the_list(person: ClientOf) -> None:
    result = wearing(LOST_MOTION, **FAR)
    viewer = person("viewer")
    page = text_of(viewer.get(f"/drives/{analysed(service_in(viewer), result)}").text)
    [(_, before)] = rows_of_report(result)
    assert before in text_of(build_fleet_index(list_of(result)))
    assert before in page


def test_a_risk_beside_the_accepted_one_is_told_from_it(person: ClientOf) -> None:
    """A page's verdict said 5.4 %, above the accepted 5 %, and its table 5 %."""
    result = wearing(LOST_MOTION)
    close = replace(result.forecasts[0], probability_crossed_by_shutdown=0.054)
    result = replace(result, forecasts=(close,))
    viewer = person("viewer")
    name = analysed(service_in(viewer), result)
    assert " 5.4 % " in section_of(text_of(viewer.get(f"/drives/{name}").text))
    assert "5.4 %" in text_of(build_fleet_index(list_of(result)))


def test_a_shutdown_before_the_last_test_is_said_to_be_one(person: ClientOf) -> None:
    """A dash stood there, and only the report told that the shutdown is to be set anew."""
    result = wearing(LOST_MOTION, shutdown=None)
    viewer = person("viewer")
    service = service_in(viewer)
    name = analysed(service, result)
    with service.store.writing() as session:
        drive = find_drive(session, name)
        assert drive is not None
        now = result.forecasts[0].now_hours
        said = content_of(drive) | {"forecast": {"next_shutdown_hours": now}}
        change_drive(session, COMMAND_LINE, drive, said)
    page = section_of(text_of(viewer.get(f"/drives/{name}").text))
    assert f"– {text_of(hours(now))} is not after the last test" in page


def test_what_is_due_within_the_hour_is_due_now(person: ClientOf) -> None:
    result = wearing(LOST_MOTION, crossing=1050.0, spread=92.5)
    assert result.forecasts[0].inspect_before_hours == pytest.approx(900.5, abs=0.5)
    assert not result.forecasts[0].already_crossed
    [(_, before)] = rows_of_report(result)
    assert before == "now"
    viewer = person("viewer")
    page = text_of(viewer.get(f"/drives/{analysed(service_in(viewer), result)}").text)
    assert section_of(page).startswith("By the horizon lost motion above 2 arcmin now ")


def test_a_forecast_that_an_earlier_version_kept_is_told_as_by_it(person: ClientOf) -> None:
    result = wearing(LOST_MOTION, **FAR)
    viewer = person("viewer")
    name = analysed(service_in(viewer), result)
    with service_in(viewer).store.writing() as session:
        session.execute(update(ForecastRow).values(horizon_hours=None))
    page = text_of(viewer.get(f"/drives/{name}").text)
    [(_, before)] = rows_of_report(result)
    at = result.forecasts[0].inspect_before_hours
    assert at is not None
    coarse = " ".join(hours(date_down(at, 900.0, math.inf)).split())
    assert coarse != before
    assert f"lost motion above 2 arcmin {coarse} " in page
