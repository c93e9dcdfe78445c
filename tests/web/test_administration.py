"""What administrators rely on: a legible trail, old pages that undo nothing, nothing piled up."""

from __future__ import annotations

import errno
import os
import re
from html import unescape

import pytest
from sqlalchemy.exc import OperationalError
from starlette.testclient import TestClient

from hdprog.store import accounts
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import add_drive, find_drive
from hdprog.store.tables import UserRow
from tests.store.samples import content
from tests.web.conftest import ClientOf, service_in
from tests.web.server import PASSWORD, csrf_of


@pytest.fixture(scope="module")
def drive(app_client: TestClient) -> str:
    name = "Prüfstand-3"
    with service_in(app_client).store.writing() as session:
        add_drive(session, COMMAND_LINE, content(name))
    return name


@pytest.mark.parametrize(("what", "field"), [("users", "user"), ("tokens", "token")])
def test_a_refused_form_keeps_what_was_typed(person: ClientOf, what: str, field: str) -> None:
    """Only a form that is empty had come back, to be filled in once more."""
    client = person("admin")
    said = {"csrf": csrf_of(client.get("/settings").text), "name": "eve & co", "role": "viewer"}
    page = client.post(f"/settings/{what}", data={**said, "password": PASSWORD})
    assert page.status_code == 422
    assert f'id="{field}-name" name="name" type="text" value="eve &amp; co"' in page.text
    role = page.text[page.text.index(f'<select id="{field}-role"') :]
    assert role.index('value="viewer" selected') < role.index("</select>")
    assert f'value="{PASSWORD}"' not in page.text


def test_the_trail_shows_letters_as_they_were_typed(drive: str, person: ClientOf) -> None:
    page = person("admin").get("/audit").text
    details = "".join(re.findall(r"<pre>(.*?)</pre>", page, re.DOTALL))
    assert f'"id": "{drive}"' in unescape(details)
    assert "<script" not in details


def test_an_old_page_does_not_switch_an_account_on_again(
    app_client: TestClient, person: ClientOf
) -> None:
    store = service_in(app_client).store
    with store.writing() as session:
        eve = accounts.add_user(session, COMMAND_LINE, "eve", PASSWORD, "engineer")
    client = person("admin")
    page = client.get("/settings").text
    form = page[page.index(f'action="/settings/users/{eve.id}"') :]
    told = re.search(r'name="seen" value="([^"]+)"', form)
    assert told is not None
    said = {"csrf": csrf_of(page), "role": "viewer", "seen": told[1]}
    with store.writing() as session:  # another administrator
        user = session.get_one(UserRow, eve.id)
        accounts.change_user(session, COMMAND_LINE, user, "engineer", disabled=True)
    answer = client.post(f"/settings/users/{eve.id}", data=said)
    assert answer.status_code == 422
    assert "opened before somebody else changed this" in answer.text
    with store.reading() as session:
        user = session.get_one(UserRow, eve.id)
        assert (user.role, user.disabled) == ("engineer", True)


@pytest.mark.parametrize("part", [None, "bytes=0-9", "bytes=999999999-", "lines=1"])
def test_a_packed_drive_leaves_nothing_behind(
    part: str | None, drive: str, app_client: TestClient, person: ClientOf
) -> None:
    headers = {} if part is None else {"range": part}
    person("viewer").get(f"/drives/{drive}/folder.zip", headers=headers)
    assert list(service_in(app_client).store.files.incoming.iterdir()) == []


@pytest.mark.parametrize("value", ["9" * 5000, "[" * 3000 + "]" * 3000])
def test_toml_beyond_all_use_is_refused_in_words(value: str, drive: str, person: ClientOf) -> None:
    client, at = person("engineer"), f"/drives/{drive}/settings"
    said = {"csrf": csrf_of(client.get(at).text), "text": f"[drive]\nratio = {value}\n"}
    answer = client.post(f"{at}/toml", data=said)
    assert answer.status_code == 422
    assert "drive.toml: found text that is not valid TOML" in answer.text


def test_json_beyond_all_use_is_refused_in_words(program: ClientOf) -> None:
    deep = '{"a":' * 600 + "1" + "}" * 600
    answer = program("engineer").post(
        "/api/v1/drives",
        content=f'{{"drive": {{"id": "deep", "x": {deep}}}}}',
        headers={"content-type": "application/json"},
    )
    assert answer.status_code == 422, answer.text


def test_a_drive_within_the_accepted_risk_is_not_counted_as_out_of_sight(
    drive: str, app_client: TestClient, person: ClientOf
) -> None:
    with service_in(app_client).store.writing() as session:
        row = find_drive(session, drive)
        assert row is not None
        row.status, row.label = "good", "Within the accepted risk"
    page = person("viewer").get("/").text
    assert "<b>1</b> Nothing to plan yet" in page
    assert "No limit in sight" not in page


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (OperationalError("SELECT", {}, OSError("cut off")), 503, "The database does not answer"),
        (OSError(errno.EDQUOT, os.strerror(errno.EDQUOT)), 507, "The disk is full"),
        (PermissionError(errno.EACCES, "no"), 500, "A mistake of ours"),
    ],
)
def test_what_the_machine_refuses_is_no_mistake_of_ours(
    app_client: TestClient, monkeypatch: pytest.MonkeyPatch, error: Exception, code: int, words: str
) -> None:
    """A database that was started anew, and a quota, had people report a mistake of the program."""

    def refused(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("hdprog.web.health.workers.alive", refused)
    answer = TestClient(app_client.app, raise_server_exceptions=False).get("/healthz")
    assert answer.status_code == code
    assert words in answer.text


def test_a_mistake_of_ours_has_the_headers_of_every_answer(
    app_client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    visitor = TestClient(app_client.app, raise_server_exceptions=False)
    monkeypatch.setattr("hdprog.web.health.workers.alive", broken)
    for address in ("/healthz", "/login"):
        answer = visitor.get(address)
        assert answer.headers["content-security-policy"].startswith("default-src 'none'")
        assert answer.headers["cache-control"] == "no-store"
        assert answer.headers["x-content-type-options"] == "nosniff"
    assert visitor.get("/healthz").status_code == 500
