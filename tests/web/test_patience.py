"""A page that waits for another's write holds up no other page."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from starlette.testclient import TestClient

from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import add_drive, find_drive
from tests.web.conftest import service_in
from tests.web.server import csrf_of, log_in


@pytest.mark.parametrize("at", ["/drives/new", "/drives/busy/settings"])
def test_others_are_answered_while_a_form_waits_to_be_written(
    app_client: TestClient, at: str
) -> None:
    log_in(app_client, "engineer")
    store = service_in(app_client).store
    with store.writing() as session:
        if find_drive(session, "busy") is None:
            add_drive(session, COMMAND_LINE, {"drive": {"id": "busy"}})
    form = {"csrf": csrf_of(app_client.get("/drives/new").text), "id": "late"}
    with ThreadPoolExecutor(2) as browsers:
        with store.writing() as session:
            assert find_drive(session, "busy") is not None
            waiting = browsers.submit(app_client.post, at, data=form)
            time.sleep(0.5)
            answer = browsers.submit(app_client.get, "/static/report.css").result(10.0)
            assert answer.status_code == 200
            assert not waiting.done()
        assert waiting.result().status_code == 200
