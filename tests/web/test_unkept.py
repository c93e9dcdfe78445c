"""What a database cannot keep is refused in words: PostgreSQL takes no NUL, none half a sign."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from hdprog.service.web_settings import WebSettings
from hdprog.store import accounts
from hdprog.store.audit import COMMAND_LINE
from hdprog.web.app import create_app
from tests.web.conftest import ClientOf, service_in
from tests.web.server import PASSWORD, csrf_of, log_in, text_of


@pytest.mark.postgres
def test_the_sign_nul_is_refused_wherever_it_is_sent(
    postgres_url: str, tmp_path: Path, loop_file: Path
) -> None:
    app = create_app(WebSettings(tmp_path, url=postgres_url, max_upload_mb=1.0))
    with TestClient(app, base_url="http://testserver") as client:
        with service_in(client).store.writing() as session:
            accounts.add_user(session, COMMAND_LINE, "admin", PASSWORD, "admin")
            token = accounts.add_token(session, COMMAND_LINE, "tests", "engineer")
        assert log_in(client, "a\0b").status_code == 422
        assert log_in(client, "admin").status_code == 303
        for path in ("/?q=%00", "/drives/a%00b", "/tests/a%00b"):
            answer = client.get(path)
            assert answer.status_code == 422
            assert "Take it out" in answer.text
        api = TestClient(app, headers={"authorization": f"Bearer {token}"})
        assert api.post("/api/v1/drives", json={"drive": {"id": "kept"}}).status_code == 201
        answer = api.post(
            "/api/v1/drives/kept/tests",
            files={"file": ("a.csv", loop_file.read_bytes())},
            data={"service_hours": "1", "note": "a\0b"},
        )
        assert answer.status_code == 422
        assert "Nothing was changed" in answer.json()["detail"]
        assert api.get("/api/v1/drives/kept").json()["waiting"] == 0
        assert not [path for path in (tmp_path / "raw").rglob("*") if path.is_file()]


def in_two_halves(**fields: str) -> dict[str, Any]:
    """Send a form whose coding lets halves of signs through, as no browser does."""
    parts = [
        f'--edge\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n{text}\r\n'
        for name, text in fields.items()
    ]
    kind = "multipart/form-data; boundary=edge; charset=unicode_escape"
    return {"content": "".join([*parts, "--edge--\r\n"]), "headers": {"content-type": kind}}


def test_half_a_sign_is_refused_wherever_it_is_sent(
    person: ClientOf, program: ClientOf, loop_file: Path
) -> None:
    api, browser = program("engineer"), person("engineer")
    assert api.post("/api/v1/drives", json={"drive": {"id": "halves"}}).status_code == 201
    sent = {"file": ("a.csv", loop_file.read_bytes())}
    said = {"service_hours": "1", "note": "whole"}
    uploaded = api.post("/api/v1/drives/halves/tests", files=sent, data=said)
    test = f"/tests/{uploaded.json()['test_uid']}"
    csrf, half = csrf_of(browser.get(test).text), "a\\ud800"
    for path, fields in (
        ("/login", {"csrf": half}),
        (test, {"csrf": csrf, "service_hours": "2", "note": half}),
        ("/drives/halves/settings", {"csrf": csrf, "model": half}),
        ("/drives/new", {"csrf": csrf, "id": half}),
    ):
        answer = browser.post(path, **in_two_halves(**fields))
        assert answer.status_code == 422, path
        assert "Take it out" in answer.text
    page = browser.get(test).text
    assert "whole" in page
    assert "1 h" in " ".join(text_of(page).split())
