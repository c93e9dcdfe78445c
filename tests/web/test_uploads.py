"""Records that wait to be looked at."""

from __future__ import annotations

from pathlib import Path

from starlette.testclient import TestClient

from tests.web.conftest import ClientOf
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
