"""A server of the tests' own, and a browser of plain requests."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from html import unescape
from pathlib import Path
from typing import Any

import httpx2 as httpx

from tests.store.postgres import free_port
from tests.terminal import hear_it_close

HDPROG = [sys.executable, "-c", "from hdprog.cli import main; main()"]
STAND_IN = Path(__file__).parent / "stand_in"
PASSWORD = "four words do well"
PATIENCE = 400.0  # seconds before a test gives up: a busy machine is no failure


def hdprog(*arguments: str, given: str = "", settings: dict[str, str] | None = None) -> str:
    """Run a command to its end; gives what it printed."""
    done = subprocess.run(
        [*HDPROG, *arguments],
        input=given,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **(settings or {})},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


class Server:
    """`hdprog serve` with its workers, on a port of its own.

    Parameters
    ----------
    data : its folder
    seconds : that a job of the stand-in takes; None for true fits
    options : of `hdprog serve`
    """

    def __init__(self, data: Path, *options: str, seconds: float | None = 0.0) -> None:
        self.data, self.options = data, options
        self.port = free_port()
        self.address = f"http://127.0.0.1:{self.port}"
        self.settings = {}
        if seconds is not None:
            # Before what is there: the server shall be of the package that the tests are of.
            path = filter(None, (str(STAND_IN), os.environ.get("PYTHONPATH")))
            self.settings = {
                "PYTHONPATH": os.pathsep.join(path),
                "STAND_IN_SECONDS": str(seconds),
            }
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> Server:
        """Start it and wait until it answers."""
        self.process = subprocess.Popen(
            [*HDPROG, "serve", "--port", str(self.port), "--data", str(self.data), *self.options],
            env={**os.environ, **self.settings},
            start_new_session=True,
            preexec_fn=hear_it_close,
        )
        ends = time.monotonic() + PATIENCE
        with httpx.Client() as client:
            while time.monotonic() < ends:
                assert self.process.poll() is None, "the server ended while it started"
                try:
                    if client.get(f"{self.address}/healthz").status_code == 200:
                        return self
                except httpx.TransportError:
                    time.sleep(0.1)
        raise AssertionError("the server did not answer")

    def kill(self) -> None:
        """End it as a power cut would."""
        if self.process is not None:
            self.process.send_signal(signal.SIGKILL)
            self.process.wait()

    def stop(self, sign: signal.Signals = signal.SIGTERM) -> int:
        """End it as its owner would; gives its exit code."""
        assert self.process is not None
        self.process.send_signal(sign)
        return self.process.wait(PATIENCE)

    def token(self, role: str = "engineer") -> str:
        """Make a token."""
        text = hdprog("token", "add", "tests", "--role", role, "--data", str(self.data))
        return text.strip()

    def api(self, role: str = "engineer") -> httpx.Client:
        """Give a program that has a token."""
        return httpx.Client(
            base_url=f"{self.address}/api/v1",
            headers={"authorization": f"Bearer {self.token(role)}"},
            timeout=PATIENCE,
        )


def csrf_of(page: str) -> str:
    """Find the token of a page's forms."""
    found = re.search(r'name="csrf" value="([0-9a-f]+)"', page)
    assert found is not None, page
    return found[1]


def text_of(page: str) -> str:
    """Give a page's words."""
    return unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page)))


def log_in(client: Any, name: str, password: str = PASSWORD) -> Any:
    """Log a client in; gives the answer."""
    csrf = csrf_of(client.get("/login").text)
    return client.post(
        "/login",
        data={"csrf": csrf, "name": name, "password": password},
        follow_redirects=False,
    )


def wait_for_jobs(
    api: httpx.Client, numbers: list[str], until: tuple[str, ...] = ("done", "failed")
) -> list[dict]:
    """Wait until jobs are in one of some states; gives what is known of them."""
    ends = time.monotonic() + PATIENCE
    while True:
        found = [api.get(f"/jobs/{number}").json() for number in numbers]
        if all(one["state"] in until for one in found):
            return found
        ended = [one for one in found if one["state"] in ("done", "failed")]
        assert set(until) & {"done", "failed"} or not ended, ended
        assert time.monotonic() < ends, found
        time.sleep(0.2)
