"""Behind nginx with TLS, as the page on running the service has it."""

from __future__ import annotations

import shutil
import ssl
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx2 as httpx
import pytest

from tests.store.postgres import free_port
from tests.web.guide import snippet
from tests.web.server import PASSWORD, PATIENCE, Server, csrf_of, hdprog, log_in, text_of

NGINX = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
OPENSSL = shutil.which("openssl")
ELSEWHERE = "127.0.0.2"  # a browser that is not at the proxy's own address

pytestmark = [
    pytest.mark.nginx,
    pytest.mark.skipif(NGINX is None or OPENSSL is None, reason="no nginx and openssl"),
]


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    hdprog("user", "add", "ada", "--data", str(data), given=PASSWORD + "\n")
    options = ("--proxy", "127.0.0.1", "--max-upload-mb", "2", "--workers", "0")
    started = Server(data, *options).start()
    yield started
    started.kill()


@pytest.fixture(scope="module")
def proxy(
    server: Server, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Callable[[], httpx.Client]]:
    """Run nginx with the snippet, its names and ports changed; gives browsers before it."""
    place, port = tmp_path_factory.mktemp("nginx"), free_port()
    certificate(place)
    text = snippet("nginx")
    for written, ours in {
        "443": f"127.0.0.1:{port}",
        "hdprog.example": "localhost",
        "/etc/ssl/": f"{place}/",
        "127.0.0.1:8000": f"127.0.0.1:{server.port}",
    }.items():
        assert written in text
        text = text.replace(written, ours)
    folders = "".join(
        f"{kind}_temp_path {place}/{kind};\n"
        for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    (place / "nginx.conf").write_text(
        f"daemon off; pid {place}/pid; error_log {place}/errors;\nevents {{}}\n"
        f"http {{\naccess_log off;\n{folders}{text}}}\n",
        "utf-8",
    )
    assert NGINX is not None
    nginx = subprocess.Popen([NGINX, "-p", str(place), "-e", "errors", "-c", "nginx.conf"])

    def browser() -> httpx.Client:
        trusted = ssl.create_default_context(cafile=str(place / "hdprog.pem"))
        way = httpx.HTTPTransport(verify=trusted, local_address=ELSEWHERE)
        at = f"https://localhost:{port}"
        return httpx.Client(base_url=at, transport=way, timeout=PATIENCE)

    try:
        wait_for(browser, place, nginx)
        yield browser
    finally:
        nginx.terminate()
        nginx.wait()


def certificate(place: Path) -> None:
    assert OPENSSL is not None
    command = (
        f"req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -keyout {place}/hdprog.key"
    )
    subprocess.run(
        [
            OPENSSL,
            *command.split(),
            "-out",
            f"{place}/hdprog.pem",
            "-addext",
            "subjectAltName=DNS:localhost",
        ],
        check=True,
        capture_output=True,
    )


def wait_for(
    browser: Callable[[], httpx.Client], place: Path, nginx: subprocess.Popen[bytes]
) -> None:
    ends = time.monotonic() + PATIENCE
    while time.monotonic() < ends:
        assert nginx.poll() is None, (place / "errors").read_text("utf-8")
        try:
            with browser() as client:
                if client.get("/healthz").status_code == 200:
                    return
        except httpx.TransportError:
            time.sleep(0.1)
    raise AssertionError("nginx did not answer")


@pytest.fixture
def client(proxy: Callable[[], httpx.Client]) -> Iterator[httpx.Client]:
    with proxy() as found:
        yield found


def test_cookies_are_for_tls_alone(client: httpx.Client) -> None:
    first = client.get("/login")
    answer = log_in(client, "ada")
    assert answer.status_code == 303
    cookies = first.headers.get_list("set-cookie") + answer.headers.get_list("set-cookie")
    given = [cookie for cookie in cookies if "Max-Age=0" not in cookie]  # others are taken back
    assert len(given) == 2
    for cookie in given:
        assert {"secure", "httponly", "samesite=lax"} <= set(cookie.lower().split("; "))
    page = client.get("/")
    assert page.status_code == 200
    assert page.headers["strict-transport-security"].startswith("max-age=")
    assert "default-src 'none'" in page.headers["content-security-policy"]
    assert page.headers["x-content-type-options"] == "nosniff"


def test_the_audit_trail_has_the_browsers_address_not_the_one_it_claims(
    client: httpx.Client,
) -> None:
    client.headers["x-forwarded-for"] = "198.51.100.7"
    assert log_in(client, "ada").status_code == 303
    words = text_of(client.get("/audit").text)
    assert ELSEWHERE in words
    assert "198.51.100.7" not in words


def test_what_is_too_large_is_said_by_hdprog(client: httpx.Client) -> None:
    log_in(client, "ada")
    form = csrf_of(client.get("/drives/new").text)
    made = client.post("/drives/new", data={"csrf": form, "id": "behind"})
    assert made.status_code == 303
    at = made.headers["location"].partition("?")[0]
    answer = client.post(
        f"{at}/uploads", data={"csrf": form}, files={"files": ("loop.csv", b"1" * 6_000_000)}
    )
    assert answer.status_code == 413
    assert "found more than 2 MB" in text_of(answer.text)
