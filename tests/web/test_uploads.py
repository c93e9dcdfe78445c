"""Records that wait to be looked at."""

from __future__ import annotations

from pathlib import Path

import pytest
from starlette.testclient import TestClient

from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import find_drive
from hdprog.store.uploads import find_test, remove
from tests.web.conftest import ClientOf, service_in
from tests.web.server import csrf_of


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
        for job in jobs.jobs_of(session, drive):
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
        assert not jobs.jobs_of(session, test.drive)
