"""Records that wait to be looked at."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import find_drive
from hdprog.store.uploads import find_test, remove
from hdprog.web.pages import uploads
from tests.web.conftest import ClientOf, service_in
from tests.web.server import csrf_of, text_of


def test_discarding_one_keeps_what_was_said_of_the_others(
    person: ClientOf, loop_file: Path
) -> None:
    client: TestClient = person("engineer")
    form = csrf_of(client.get("/drives/new").text)
    at = "/drives/two-records"
    assert client.post("/drives/new", data={"csrf": form, "id": "two-records"}).status_code == 200
    records = [loop_file.with_name(name).read_bytes() for name in ("t01.csv", "t02.csv")]
    page = client.post(
        f"{at}/uploads",
        data={"csrf": form},
        files=[("files", (f"r{n}.csv", record)) for n, record in enumerate(records)],
    ).text
    first, second = [line.split('"')[0] for line in page.split('<h2 id="')[1:]]
    said = {f"{first}-service_hours": "", f"{second}-service_hours": "123.5"}
    left = client.post(f"{at}/uploads/accept", data={"csrf": form, **said, "discard": first}).text
    assert f'<h2 id="{first}"' not in left
    assert 'value="123.5"' in left


def test_one_record_under_two_names_is_said_to_wait_once(person: ClientOf, loop_file: Path) -> None:
    client: TestClient = person("engineer")
    form = csrf_of(client.get("/drives/new").text)
    assert client.post("/drives/new", data={"csrf": form, "id": "two-names"}).status_code == 200
    record = loop_file.read_bytes()
    page = client.post(
        "/drives/two-names/uploads",
        data={"csrf": form},
        files=[("files", ("a.csv", record)), ("files", ("b.csv", record))],
    )
    assert page.status_code == 200
    assert "b.csv is the same record as a.csv, byte by byte: it waits once." in page.text
    assert page.text.count('<h2 id="') == 1


def test_a_file_without_known_columns_leads_to_where_they_are_named(person: ClientOf) -> None:
    client: TestClient = person("engineer")
    form = csrf_of(client.get("/drives/new").text)
    assert client.post("/drives/new", data={"csrf": form, "id": "columns"}).status_code == 200
    rows = "".join(f"{n},{n}\n" for n in range(50)).encode()
    page = client.post(
        "/drives/columns/uploads",
        data={"csrf": form},
        files={"files": ("odd.csv", b"left,right\n" + rows)},
    )
    assert page.status_code == 422
    assert '<a href="/drives/columns/settings">' in page.text


def test_a_record_that_comes_again_starts_its_failed_job_again(
    program: ClientOf, loop_file: Path
) -> None:
    """The answer had named the failed job, and nobody did it."""
    client = program("engineer")
    store = service_in(client).store
    assert client.post("/api/v1/drives", json={"drive": {"id": "again"}}).status_code == 201

    def upload(name: str) -> str:
        answer = client.post(
            "/api/v1/drives/again/tests",
            files={"file": (name, loop_file.with_name(name).read_bytes())},
            data={"service_hours": "1" if name == "t01.csv" else "2"},
        )
        return str(answer.json()["job_id"])

    def state(number: str) -> str:
        return str(client.get(f"/api/v1/jobs/{number}").json()["state"])

    first, second = upload("t01.csv"), upload("t02.csv")
    for number in (first, second):
        with store.writing() as session:
            job = jobs.find_job(session, number)
            assert job is not None
            jobs.fail(session, job, jobs.start(session, job), "No space left on device")
    assert upload("t01.csv") == first
    assert state(first) == "queued"
    assert upload("t02.csv") == first  # which holds the second test as well
    assert state(second) == "failed"
    client.post(f"/api/v1/jobs/{first}/cancel")
    assert upload("t01.csv") == first
    assert state(first) == "failed"  # a person called it off


def test_a_removed_record_that_comes_again_is_analysed(program: ClientOf, loop_file: Path) -> None:
    client = program("engineer")
    assert client.post("/api/v1/drives", json={"drive": {"id": "back"}}).status_code == 201

    def upload(hours: str) -> dict[str, object]:
        answer = client.post(
            "/api/v1/drives/back/tests",
            files={"file": ("a.csv", loop_file.read_bytes())},
            data={"service_hours": hours},
        )
        assert answer.status_code == 202
        return answer.json()

    first = upload("100")
    store = service_in(client).store
    with store.writing() as session:
        test, drive = find_test(session, str(first["test_uid"])), find_drive(session, "back")
        assert test is not None
        assert drive is not None
        remove(session, COMMAND_LINE, test)
        drive.tests = 0
        for job in jobs.open_jobs_of(session, drive):
            job.state = "done"
    again = upload("150")
    assert again["new"] is False
    assert again["job_id"] != first["job_id"]
    assert client.get(f"/api/v1/jobs/{again['job_id']}").json()["state"] == "queued"
    with store.reading() as session:
        drive = find_drive(session, "back")
        assert drive is not None
        assert (drive.tests, drive.last_test_hours) == (1, 150.0)
    assert upload("150")["job_id"] == again["job_id"]


@pytest.mark.parametrize("said", [{"service_hours": "5"}, {"remove": "yes"}])
def test_only_a_test_that_counts_is_changed_on_its_page(
    program: ClientOf, person: ClientOf, loop_file: Path, said: dict[str, str]
) -> None:
    name = f"states-{next(iter(said))}"
    made = program("engineer").post("/api/v1/drives", json={"drive": {"id": name}})
    assert made.status_code == 201
    client = person("engineer")
    form = csrf_of(client.get("/drives/new").text)
    page = client.post(
        f"/drives/{name}/uploads",
        data={"csrf": form},
        files={"files": ("a.csv", loop_file.read_bytes())},
    ).text
    uid = page.split('<h2 id="')[1].split('"')[0]
    waiting = client.post(f"/tests/{uid}", data={"csrf": form, **said})
    assert waiting.status_code == 409
    assert "Accept or discard it" in waiting.text
    client.post(f"/drives/{name}/uploads/accept", data={"csrf": form, "discard": uid})
    removed = client.post(f"/tests/{uid}", data={"csrf": form, **said})
    assert removed.status_code == 409
    assert "Upload its record again" in removed.text
    drive = client.get(f"/drives/{name}").text
    assert "1 removed or discarded record<" in drive
    assert f'href="/tests/{uid}"' in drive
    with service_in(client).store.reading() as session:
        test = find_test(session, uid)
        assert test is not None
        assert test.state == "removed"
        assert jobs.last_job_of(session, test.drive) is None


def waiting_record(client: TestClient, name: str, record: bytes) -> tuple[str, str]:
    """A drive with a record that waits; the form's token and the record's uid."""
    form = csrf_of(client.get("/drives/new").text)
    assert client.post("/drives/new", data={"csrf": form, "id": name}).status_code == 200
    sent = {"files": ("a.csv", record)}
    page = client.post(f"/drives/{name}/uploads", data={"csrf": form}, files=sent).text
    return form, page.split('<h2 id="')[1].split('"')[0]


def test_what_others_did_meanwhile_is_said_and_not_undone(
    person: ClientOf, loop_file: Path
) -> None:
    client = person("engineer")
    form, uid = waiting_record(client, "meanwhile", loop_file.read_bytes())
    at = "/drives/meanwhile/uploads/accept"
    first = client.post(at, data={"csrf": form, f"{uid}-service_hours": "900"})
    assert first.status_code == 200
    old = {"csrf": form, f"{uid}-service_hours": "700"}
    for said in (old, {"csrf": form, "discard": uid}):
        answer = client.post(at, data=said)
        assert answer.status_code == 409
        assert "somebody has accepted it meanwhile" in answer.text
    page = client.get(f"/tests/{uid}").text
    assert "900" in page
    shown = page.split('name="seen" value="')[1].split('"')[0]
    corrected = {"csrf": form, "seen": shown, "service_hours": "1500", "note": "by the first"}
    mistyped = client.post(f"/tests/{uid}", data={**corrected, "temperature_C": "warm"})
    assert mistyped.status_code == 422
    for typed in ("1500", "by the first", "warm"):  # nothing of it has to be typed again
        assert f'value="{typed}"' in mistyped.text
    assert client.post(f"/tests/{uid}", data=corrected).status_code == 200
    late = {"csrf": form, "seen": shown, "service_hours": "900", "temperature_C": "25"}
    answer = client.post(f"/tests/{uid}", data=late)
    assert answer.status_code == 422
    assert "opened before somebody else changed this" in answer.text
    mistyped = client.post(f"/tests/{uid}", data={**late, "temperature_C": "warm"})
    assert f'name="seen" value="{shown}"' in mistyped.text  # still out of date
    with service_in(client).store.reading() as session:
        test = find_test(session, uid)
        assert test is not None
        assert (test.service_hours, test.note, test.temperature_C) == (1500.0, "by the first", None)


def test_a_settings_page_that_is_out_of_date_changes_nothing(person: ClientOf) -> None:
    client = person("engineer")
    form = csrf_of(client.get("/drives/new").text)
    assert client.post("/drives/new", data={"csrf": form, "id": "stale"}).status_code == 200
    at = "/drives/stale/settings"
    shown = client.get(at).text.split('name="seen" value="')[1].split('"')[0]
    both = {"csrf": form, "seen": shown}
    assert client.post(at, data={**both, "rated_torque_Nm": "63"}).status_code == 200
    late = client.post(at, data={**both, "forecast_next_shutdown_hours": "500"})
    assert late.status_code == 422
    assert "opened before somebody else changed this" in late.text
    for text in ('[drive]\nid = "stale"\n', "[drive"):
        answer = client.post(f"{at}/toml", data={**both, "text": text})
        assert answer.status_code == 422
        assert "opened before somebody else changed this" in answer.text
        assert "rated_torque_Nm = 63.0" in answer.text
    assert 'value="63' in client.get(at).text


def test_a_new_drives_hours_go_on(program: ClientOf, person: ClientOf, loop_file: Path) -> None:
    client = program("engineer")
    assert client.post("/api/v1/drives", json={"drive": {"id": "anew"}}).status_code == 201
    record = loop_file.read_bytes()

    def upload(number: int, **facts: str) -> Any:
        return client.post(
            "/api/v1/drives/anew/tests",
            files={"file": ("a.csv", b"#%d\n" % number + record)},
            data=facts,
        )

    assert upload(1, service_hours="1000").status_code == 202
    refused = upload(2, service_hours="10", event="replaced")
    assert refused.status_code == 422
    assert "hours that go on counting" in refused.json()["detail"]
    assert upload(2, service_hours="1010", event="replaced").status_code == 202
    assert upload(3, service_hours="1500", note="a\x00b").status_code == 422


def test_the_old_drives_tests_may_come_later_with_fewer_hours(
    program: ClientOf, loop_file: Path
) -> None:
    """One with more was taken, and every analysis of the drive then failed."""
    client = program("engineer")
    assert client.post("/api/v1/drives", json={"drive": {"id": "old-later"}}).status_code == 201
    record = loop_file.read_bytes()

    def upload(number: int, hours: int, date: str, event: str = "") -> Any:
        return client.post(
            "/api/v1/drives/old-later/tests",
            files={"file": ("a.csv", b"#%d\n" % number + record)},
            data={"service_hours": str(hours), "date": date, "event": event},
        )

    assert upload(1, 1000, "2025-06-01", "replaced").status_code == 202
    refused = upload(2, 5000, "2025-01-01")
    assert refused.status_code == 422
    assert "a new drive's first (event replaced)" in refused.json()["detail"]
    assert upload(2, 900, "2025-01-01").status_code == 202
    assert upload(3, 5000, "2025-07-01").status_code == 202


def test_a_page_shows_no_more_records_than_its_form_can_send(
    person: ClientOf, loop_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(uploads, "_MOST_SHOWN", 2)
    client = person("engineer")
    form = csrf_of(client.get("/drives/new").text)
    assert client.post("/drives/new", data={"csrf": form, "id": "many"}).status_code == 200
    record = loop_file.read_bytes()
    files = [("files", (f"{n}.csv", b"#%d\n" % n + record)) for n in range(3)]
    page = client.post("/drives/many/uploads", data={"csrf": form}, files=files).text
    assert page.count('-service_hours" name=') == 2
    assert "1 more record waits" in page


def test_the_same_readings_in_another_form_are_told_and_taken(
    program: ClientOf, person: ClientOf, loop_file: Path
) -> None:
    """They counted as another test without a word."""
    api, browser, record = program("engineer"), person("engineer"), loop_file.read_bytes()
    assert api.post("/api/v1/drives", json={"drive": {"id": "twice"}}).status_code == 201

    def send(name: str, data: bytes, hours: str) -> dict[str, Any]:
        answer = api.post(
            "/api/v1/drives/twice/tests",
            files={"file": (name, data)},
            data={"service_hours": hours},
        )
        assert answer.status_code == 202
        found: dict[str, Any] = answer.json()
        return found

    words = "Torque and angle are those of test {}, reading by reading"
    first = send("a.csv", record, "0")
    assert "reading by reading" not in str(first["warnings"])
    again = send("a.csv.gz", gzip.compress(record), "100")
    assert any(words.format(first["test_id"]) in doubt for doubt in again["warnings"])
    assert words.format(first["test_id"]) in text_of(
        browser.get(f"/tests/{again['test_uid']}").text
    )
    csrf = csrf_of(browser.get("/drives/twice").text)
    files = {"files": ("b.csv", record.replace(b"\n", b"\r\n"))}
    page = browser.post("/drives/twice/uploads", data={"csrf": csrf}, files=files)
    assert words.format(first["test_id"]) in text_of(page.text)
    browser.post(f"/tests/{first['test_uid']}", data={"csrf": csrf, "remove": "1"})
    left = text_of(browser.get(f"/tests/{again['test_uid']}").text)
    assert "reading by reading" not in left
    assert words.format(again["test_id"]) in text_of(browser.get("/drives/twice/uploads").text)
