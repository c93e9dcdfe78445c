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
