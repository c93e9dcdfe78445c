"""Two forms in the same instant: the second is told that what it showed has changed."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from hdprog.service.web_settings import WebSettings
from hdprog.store import accounts
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import change_drive, content_of, find_drive
from hdprog.store.uploads import accept, facts_of, find_test, hold_drive_of
from hdprog.web.app import create_app
from tests.store.samples import add_sample
from tests.web.conftest import service_in
from tests.web.server import PASSWORD, csrf_of, log_in

_HEAD_START = 0.5  # s, for the second form to be read and to come to where it must wait


@pytest.mark.parametrize("what", ["settings", "settings/toml", "test"])
def test_the_second_of_two_forms_is_refused(
    database_url: str, tmp_path: Path, loop_file: Path, what: str
) -> None:
    app = create_app(WebSettings(tmp_path, url=database_url, max_upload_mb=1.0))
    with TestClient(app, base_url="http://testserver") as client, ThreadPoolExecutor(1) as browser:
        store = service_in(client).store
        with store.writing() as session:
            accounts.add_user(session, COMMAND_LINE, "ada", PASSWORD, "engineer")
            token = accounts.add_token(session, COMMAND_LINE, "tests", "engineer")
            add_sample(session, "one")
        uploaded = client.post(
            "/api/v1/drives/one/tests",
            files={"file": ("a.csv", loop_file.read_bytes())},
            data={"service_hours": "1"},
            headers={"authorization": f"Bearer {token}"},
        )
        uid = uploaded.json()["test_uid"]
        log_in(client, "ada")
        page = client.get(f"/tests/{uid}" if what == "test" else "/drives/one/settings").text
        shown = page.split('name="seen" value="')[1].split('"')[0]
        said = {"csrf": csrf_of(page), "seen": shown, "service_hours": "700"}
        said |= {"text": '[drive]\nid = "one"\n', "rated_torque_Nm": "50"}
        at = f"/tests/{uid}" if what == "test" else f"/drives/one/{what}"
        with store.writing() as session:  # the first form
            hold_drive_of(session, uid)
            drive, test = find_drive(session, "one"), find_test(session, uid)
            assert drive is not None
            assert test is not None
            second = browser.submit(client.post, at, data=said)
            with pytest.raises(TimeoutError):
                second.result(_HEAD_START)
            accept(session, COMMAND_LINE, test, replace(facts_of(test), service_hours=900.0))
            before = content_of(drive)
            declared = {**before, "drive": {**before["drive"], "ratio": 80.0}}
            change_drive(session, COMMAND_LINE, drive, declared)
        answer = second.result()
        assert answer.status_code == 422
        assert "opened before somebody else changed this" in answer.text
        with store.reading() as session:
            drive, test = find_drive(session, "one"), find_test(session, uid)
            assert drive is not None
            assert test is not None
            assert content_of(drive) == declared
            assert test.service_hours == 900.0
        shows = "900" if what == "test" else "ratio = 80.0"
        assert shows in answer.text
