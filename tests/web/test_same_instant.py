"""Two changes in the same instant: the second goes by what the first one left."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from hdprog.service.analyse import Analysis
from hdprog.service.web_settings import WebSettings
from hdprog.store import accounts, jobs
from hdprog.store.audit import COMMAND_LINE, trail
from hdprog.store.drives import change_drive, content_of, find_drive
from hdprog.store.settings import ServiceSettings, change_settings, service_settings
from hdprog.store.store import Store
from hdprog.store.tables import JobRow, UserRow
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


@pytest.fixture
def browser() -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(1) as made:
        yield made


def under_way(store: Store) -> tuple[str, int]:
    """Make a job that a worker has; gives its number and the attempt."""
    with store.writing() as session:
        job = jobs.add_job(session, COMMAND_LINE, add_sample(session, "one"), None)
        return job.id, jobs.start(session, job)


def require_waiting(second: Future[object]) -> None:
    with pytest.raises(TimeoutError):
        second.result(_HEAD_START)


def test_a_job_that_ends_while_it_is_called_off_is_done(
    database_url: str, tmp_path: Path, browser: ThreadPoolExecutor
) -> None:
    app = create_app(WebSettings(tmp_path, url=database_url))
    with TestClient(app, base_url="http://testserver") as client:
        store = service_in(client).store
        number, attempt = under_way(store)
        with store.writing() as session:
            token = accounts.add_token(session, COMMAND_LINE, "tests", "engineer")
        client.headers["authorization"] = f"Bearer {token}"
        with store.writing() as session:
            job = jobs.find_job(session, number, alone=True)
            assert job is not None
            second = browser.submit(client.post, f"/api/v1/jobs/{number}/cancel")
            require_waiting(second)
            assert jobs.finish(session, job, attempt, None)
        answer = second.result().json()
        assert (answer["state"], answer["cancelled"], answer["error"]) == ("done", False, None)
        assert client.get(f"/api/v1/jobs/{number}").json() == answer


def test_a_job_that_is_called_off_while_it_ends_is_not_done(
    store: Store, browser: ThreadPoolExecutor
) -> None:
    number, attempt = under_way(store)
    with store.writing() as session:
        job = jobs.find_job(session, number, alone=True)
        assert job is not None
        second = browser.submit(Analysis(store, number, attempt).run, 1, None)
        require_waiting(second)
        assert jobs.cancel(session, COMMAND_LINE, job)
    second.result()
    with store.reading() as session:
        kept = session.get_one(JobRow, number)
        assert (kept.state, kept.stage, kept.cancelled) == ("failed", "cancelled", True)
        assert kept.progress < 1.0


def test_a_job_that_is_called_off_while_a_worker_takes_it_up_is_not_begun(
    store: Store, browser: ThreadPoolExecutor
) -> None:
    with store.writing() as session:
        number = jobs.add_job(session, COMMAND_LINE, add_sample(session, "one"), None).id

    def take_up() -> JobRow | None:
        with store.writing() as session:
            return jobs.next_job(session, number)

    with store.writing() as session:
        job = jobs.find_job(session, number, alone=True)
        assert job is not None
        second = browser.submit(take_up)
        require_waiting(second)
        assert jobs.cancel(session, COMMAND_LINE, job)
    assert second.result() is None


def test_two_administrators_who_demote_each_other_leave_one(
    database_url: str, tmp_path: Path, browser: ThreadPoolExecutor
) -> None:
    app = create_app(WebSettings(tmp_path, url=database_url))
    with TestClient(app, base_url="http://testserver") as client:
        store = service_in(client).store
        with store.writing() as session:
            ada, bob = (
                accounts.add_user(session, COMMAND_LINE, name, PASSWORD, "admin")
                for name in ("ada", "bob")
            )
        log_in(client, "ada")
        said = {"csrf": csrf_of(client.get("/settings").text), "role": "viewer"}
        with store.writing() as session:  # bob's form
            user = session.get_one(UserRow, ada.id)
            accounts.change_user(session, COMMAND_LINE, user, "viewer", disabled=False)
            second = browser.submit(client.post, f"/settings/users/{bob.id}", data=said)
            require_waiting(second)
        assert second.result().status_code == 422
        with store.reading() as session:
            roles = [user.role for user in accounts.users(session)]
        assert roles == ["viewer", "admin"]


def test_two_first_changes_of_the_settings_are_both_kept(
    store: Store, browser: ThreadPoolExecutor
) -> None:
    """The second ended as a mistake of the program, and so did the second server's start."""

    def change(title: str) -> None:
        with store.writing() as session:
            change_settings(session, COMMAND_LINE, ServiceSettings(title))

    with store.writing() as session:
        change_settings(session, COMMAND_LINE, ServiceSettings("first"))
        second = browser.submit(change, "second")
        require_waiting(second)
    second.result()
    with store.reading() as session:
        assert service_settings(session).title == "second"
        assert [line.details["before"]["title"] for line in trail(session)] == ["first", ""]
