"""A doubt about a record that counts already, as a program's does, can be answered."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from starlette.testclient import TestClient

from hdprog.store.audit import trail
from hdprog.store.uploads import find_test
from tests.store.samples import jobs_of
from tests.web.conftest import ClientOf, service_in
from tests.web.server import csrf_of, text_of
from tests.web.test_read_out import upload

QUESTION = "Is this the right drive?"


def doubted(api: TestClient, name: str, loop_file: Path) -> str:
    """Make a drive with a test and a softer one; gives the uid of the second."""
    assert api.post("/api/v1/drives", json={"drive": {"id": name}}).status_code == 201
    upload(api, name, loop_file.read_bytes())
    head, *rows = loop_file.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    softer = [",".join([*some, str(1.5 * float(angle))]) for *some, angle in cells]
    found = upload(api, name, "\n".join([head, *softer]).encode(), "2")
    assert QUESTION in found["warnings"][0]
    return str(found["test_uid"])


def hidden(page: str, name: str) -> str:
    return page.split(f'name="{name}" value="')[1].split('"')[0]


def jobs_and_answers(api: TestClient, uid: str) -> tuple[int, list[Any]]:
    with service_in(api).store.reading() as session:
        test = find_test(session, uid)
        assert test is not None
        lines = [one for one in trail(session) if one.subject.startswith(test.drive.name)]
        answers = [one.actor for one in lines if one.action == "right drive confirmed"]
        return len(jobs_of(session, test.drive)), answers


def test_an_engineer_answers_for_a_record_that_counts(
    program: ClientOf, person: ClientOf, loop_file: Path
) -> None:
    """The question stood there in red for good, and nothing could be done about it."""
    api, client, viewer = program("engineer"), person("engineer"), person("viewer")
    uid = doubted(api, "asked-of", loop_file)
    for page in (client.get(f"/tests/{uid}").text, client.get("/drives/asked-of").text):
        assert QUESTION in page
    for page in (viewer.get(f"/tests/{uid}").text, viewer.get("/drives/asked-of").text):
        assert "Ask an engineer to answer" in page
        assert 'name="right_drive"' not in page
    page = client.get(f"/tests/{uid}").text
    before, _ = jobs_and_answers(api, uid)
    said = {"csrf": csrf_of(page), "right_drive": "yes", "asked": "of another doubt"}
    assert viewer.post(f"/tests/{uid}", data={**said, "csrf": ""}).status_code == 403
    late = client.post(f"/tests/{uid}", data=said)
    assert late.status_code == 422
    assert jobs_and_answers(api, uid) == (before, [])
    answered = client.post(f"/tests/{uid}", data={**said, "asked": hidden(page, "asked")})
    assert QUESTION not in answered.text
    assert "That it is the right drive was said by engineer on" in text_of(answered.text)
    assert QUESTION not in client.get("/drives/asked-of").text
    assert jobs_and_answers(api, uid) == (before, ["engineer"])


def test_who_answers_no_takes_the_test_out(
    program: ClientOf, person: ClientOf, loop_file: Path
) -> None:
    api, client = program("engineer"), person("engineer")
    uid = doubted(api, "not-its", loop_file)
    page = client.get(f"/tests/{uid}").text
    said = {name: hidden(page, name) for name in ("csrf", "seen", "asked")}
    assert client.post(f"/tests/{uid}", data={**said, "remove": "yes"}).status_code == 200
    for page in (client.get(f"/tests/{uid}").text, client.get("/drives/not-its").text):
        assert QUESTION not in page
    answered = client.post(f"/tests/{uid}", data={**said, "right_drive": "yes"})
    assert answered.status_code == 409
    assert jobs_and_answers(api, uid)[1] == []
