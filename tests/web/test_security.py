"""Who gets in, what forms carry, what answers say to browsers."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import quote, unquote

import pytest
from starlette.testclient import TestClient

from hdprog.service.web_settings import WebSettings
from hdprog.store import accounts
from hdprog.store.audit import COMMAND_LINE, trail
from hdprog.store.logins import close_session
from hdprog.web.app import create_app
from hdprog.web.security.identity import SESSION
from tests.web.conftest import ClientOf, service_in
from tests.web.server import PASSWORD, csrf_of, log_in, text_of

PAGES = ("/", "/drives/new", "/settings", "/audit")


@pytest.mark.parametrize("path", [*PAGES, "/drives/x", "/tests/x", "/drives/x/report"])
def test_pages_need_a_login(app_client: TestClient, path: str) -> None:
    answer = TestClient(app_client.app).get(path, follow_redirects=False)
    assert answer.status_code == 303
    assert answer.headers["location"].startswith("/login?next=")


@pytest.mark.parametrize(
    ("role", "allowed"),
    [
        ("viewer", {"/", "/settings"}),
        ("engineer", {"/", "/settings", "/drives/new"}),
        ("admin", {*PAGES}),
    ],
)
def test_what_each_role_sees(person: ClientOf, role: str, allowed: set[str]) -> None:
    client = person(role)
    assert {path for path in PAGES if client.get(path).status_code == 200} == allowed
    assert all(client.get(path).status_code == 403 for path in {*PAGES} - allowed)


def test_a_viewer_changes_nothing(person: ClientOf) -> None:
    client = person("viewer")
    csrf = csrf_of(client.get("/settings").text)
    for path in ("/drives/new", "/settings/users", "/settings/tokens", "/settings/service"):
        assert client.post(path, data={"csrf": csrf, "name": "x", "id": "x"}).status_code == 403


def test_a_viewer_is_led_nowhere_that_is_closed_to_them(person: ClientOf, loop_file: Path) -> None:
    """A page led viewers to records that wait, and told them to upload where no form is."""
    engineer, viewer = person("engineer"), person("viewer")
    csrf = csrf_of(engineer.get("/drives/new").text)
    engineer.post("/drives/new", data={"csrf": csrf, "id": "looked-at"})
    assert "Ask an engineer to upload" in viewer.get("/drives/looked-at").text
    record = {"files": ("a.csv", b"#v\n" + loop_file.read_bytes())}
    page = engineer.post("/drives/looked-at/uploads", data={"csrf": csrf}, files=record).text
    [uid] = re.findall(r'<h2 id="([^"]+)"', page)
    for path in ("/drives/looked-at", f"/tests/{uid}"):
        for address in re.findall(r'<a [^>]*href="(/[^"]*)"', viewer.get(path).text):
            assert viewer.get(address).status_code != 403, (path, address)


def test_the_cookie_is_out_of_scripts_reach(app_client: TestClient) -> None:
    answer = log_in(TestClient(app_client.app), "viewer")
    cookie = next(c for c in answer.headers.get_list("set-cookie") if "hdprog_session" in c)
    assert "HttpOnly" in cookie
    assert "SameSite=lax" in cookie
    assert "Secure" not in cookie
    answer = log_in(TestClient(app_client.app, base_url="https://testserver"), "viewer")
    cookie = next(c for c in answer.headers.get_list("set-cookie") if "hdprog_session" in c)
    assert "Secure" in cookie


@pytest.mark.parametrize("csrf", ["", "0" * 64, "ü"])
def test_forms_from_elsewhere_do_nothing(person: ClientOf, csrf: str) -> None:
    client = person("admin")
    answer = client.post("/settings/service", data={"csrf": csrf, "title": "taken over"})
    assert answer.status_code == 403
    assert "taken over" not in client.get("/").text


def test_anothers_form_token_does_nothing(person: ClientOf) -> None:
    other = csrf_of(person("admin").get("/settings").text)
    answer = person("admin").post("/settings/service", data={"csrf": other, "title": "taken over"})
    assert answer.status_code == 403


def test_logging_out_ends_the_session(person: ClientOf) -> None:
    client = person("viewer")
    cookie = client.cookies["hdprog_session"]
    csrf = csrf_of(client.get("/").text)
    client.post("/logout", data={"csrf": csrf})
    client.cookies.set("hdprog_session", cookie)
    assert client.get("/", follow_redirects=False).status_code == 303


@pytest.mark.parametrize(
    "next_page",
    ["https://evil.example", "//evil.example", "/\\evil.example", "javascript:x", "/ x"],
)
def test_a_login_leads_nowhere_else(app_client: TestClient, next_page: str) -> None:
    client = TestClient(app_client.app)
    csrf = csrf_of(client.get("/login", params={"next": next_page}).text)
    said = {"csrf": csrf, "name": "viewer", "password": "four words do well", "next": next_page}
    answer = client.post("/login", data=said, follow_redirects=False)
    assert answer.headers["location"] == "/"


@pytest.mark.parametrize("name", ["cell 3 axis 2", "Achse ä+", "試" * 100])
def test_a_login_leads_to_the_page_that_was_asked_for(app_client: TestClient, name: str) -> None:
    """A drive with a space in its name led to the fleet."""
    client = TestClient(app_client.app)
    asked = client.get(f"/drives/{quote(name)}", follow_redirects=False)
    page = client.get(asked.headers["location"]).text
    [given] = re.findall(r'name="next" value="([^"]*)"', page)
    said = {"csrf": csrf_of(page), "name": "viewer", "password": PASSWORD, "next": given}
    answer = client.post("/login", data=said, follow_redirects=False)
    assert unquote(answer.headers["location"]) == f"/drives/{name}"


def test_a_form_that_outlives_its_session_is_said_to_have_done_nothing(
    app_client: TestClient, person: ClientOf
) -> None:
    """A bare login followed, and then the fleet: records passed for accepted that were not."""
    engineer = person("engineer")
    csrf = csrf_of(engineer.get("/drives/new").text)
    with service_in(app_client).store.writing() as session:
        close_session(session, engineer.cookies[SESSION])
    page = engineer.post("/drives/new", data={"csrf": csrf, "id": "too-late"})
    assert "Your session has ended: nothing of the form was done." in text_of(page.text)
    assert person("viewer").get("/drives/too-late").status_code == 404


def test_wrong_passwords_are_counted_where_one_is_changed_too(app_client: TestClient) -> None:
    """Who finds a browser logged in could try passwords without end."""
    store = service_in(app_client).store
    with store.writing() as session:
        accounts.add_user(session, COMMAND_LINE, "left-open", PASSWORD, "viewer")
    browser = TestClient(app_client.app, client=("left-open", 1))
    assert log_in(browser, "left-open").status_code == 303
    csrf = csrf_of(browser.get("/settings").text)

    def change(old: str) -> int:
        said = {"csrf": csrf, "old": old, "new": "another four words"}
        return int(browser.post("/settings/password", data=said).status_code)

    assert [change("wrong password") for _ in range(10)] == [422] * 10
    assert change(PASSWORD) == 429
    with store.reading() as session:
        noted = [line.action for line in trail(session) if line.subject == "left-open"]
        assert noted.count("wrong password") == 10
        assert "password changed" not in noted


def test_wrong_passwords_are_counted(app_client: TestClient) -> None:
    client = TestClient(app_client.app, client=("10.9.8.7", 1))
    codes = [log_in(client, "nobody", "wrong password").status_code for _ in range(11)]
    assert codes == [401] * 10 + [429]
    client = TestClient(app_client.app, client=("10.9.8.6", 1))
    assert log_in(client, "viewer").status_code == 303


def test_passwords_tried_side_by_side_are_counted_like_those_in_turn(
    app_client: TestClient,
) -> None:
    def tried(_: int) -> int:
        browser = TestClient(app_client.app, client=("10.9.8.5", 1))
        return int(log_in(browser, "nobody-either", "wrong password").status_code)

    with ThreadPoolExecutor(13) as threads:
        codes = sorted(threads.map(tried, range(13)))
    assert codes == [401] * 10 + [429] * 3
    with service_in(app_client).store.reading() as session:
        noted = [line.action for line in trail(session) if line.subject == "nobody-either"]
    assert noted == ["login failed"] * 10  # a trail grows by what was checked


def test_headers_of_pages(person: ClientOf) -> None:
    headers = person("viewer").get("/").headers
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["cache-control"] == "no-store"


@pytest.mark.parametrize("path", [*PAGES, "/login", "/nosuch", "/drives/nosuch"])
def test_pages_bring_no_script_or_style_of_their_own(person: ClientOf, path: str) -> None:
    page = person("admin").get(path).text
    assert "<script>" not in page
    assert " style=" not in page
    assert " onclick" not in page
    assert "http://" not in page.replace("http://testserver", "")
    assert "https://" not in page


@pytest.mark.parametrize(
    "path",
    [
        "/static/../app.py",
        "/static/%2e%2e/app.py",
        "/static/..%2fapp.py",
        "/static/%2fetc/passwd",
        "/drives/..%2f..%2fetc%2fpasswd",
        "/tests/..%2f..%2fhdprog.db/record",
        "/tests/%00/record",
        "/drives/%2e%2e/report",
    ],
)
def test_tricks_with_paths(person: ClientOf, path: str) -> None:
    answer = person("admin").get(path)
    assert answer.status_code in (404, 422)
    assert "root:" not in answer.text


def test_without_login_other_names_are_refused(tmp_path: Path) -> None:
    settings = WebSettings(tmp_path, login=False, hosts=("localhost", "127.0.0.1", "[::1]"))
    with TestClient(create_app(settings), base_url="http://127.0.0.1:8000") as client:
        assert client.get("/").status_code == 200
        assert "Log out" not in text_of(client.get("/").text)
        for host in ("LOCALHOST", "[::1]:8000"):
            assert client.get("/", headers={"host": host}).status_code == 200
        for host in ("evil.example", "evil.example:8000", "127.0.0.1@evil.example", "[", ""):
            refused = client.get("/", headers={"host": host})
            assert refused.status_code == 400
            assert "expected one of localhost, 127.0.0.1, [::1], as" in text_of(refused.text)
            assert "csrf" not in refused.text
        refused = client.get("/api/v1/drives", headers={"host": "evil.example"})
        assert refused.status_code == 400
        assert refused.json()["detail"].startswith("Host: found 'evil.example'; expected")
        assert client.get("/api/v1/drives").status_code == 401


def test_a_new_password_needs_the_old_one(person: ClientOf) -> None:
    client = person("viewer")
    csrf = csrf_of(client.get("/settings").text)
    said = {"csrf": csrf, "old": "not this one", "new": "another four words"}
    assert client.post("/settings/password", data=said).status_code == 422


def test_a_token_is_shown_once(person: ClientOf) -> None:
    client = person("admin")
    csrf = csrf_of(client.get("/settings").text)
    page = client.post("/settings/tokens", data={"csrf": csrf, "name": "rig", "role": "engineer"})
    assert "hdp_" in page.text
    assert "hdp_" not in client.get("/settings").text
    assert "hdp_" not in client.get("/audit").text


@pytest.mark.parametrize("path", ["users/{}", "tokens/{}/revoke"])
def test_a_number_that_no_row_can_have_is_not_found(person: ClientOf, path: str) -> None:
    client = person("admin")
    said = {"csrf": csrf_of(client.get("/settings").text), "role": "viewer"}
    for number in (0, 2**31, 10**30):
        assert client.post(f"/settings/{path.format(number)}", data=said).status_code == 404
