"""The server as it is run: killed and started again, under many uploads, under a flood."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hdprog.cli import app
from hdprog.data.synthetic import write_drive_folder
from tests.terminal import hear_it_close
from tests.web.server import HDPROG, PASSWORD, PATIENCE, Server, hdprog, wait_for_jobs

DRIVE = {
    "drive": {"id": "cell3-axis2", "model": "CSF-25-80", "rated_torque_Nm": 63.0},
    "limits": [{"quantity": "lost_motion_arcmin", "above": 2.0}],
}


@pytest.fixture
def started() -> Iterator[list[Server]]:
    servers: list[Server] = []
    yield servers
    for server in servers:
        server.kill()


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    """Make fifty records that differ."""
    folder = simulated(tmp_path_factory.mktemp("drive") / "many", tests=5)
    loops = [path.read_bytes() for path in sorted((folder / "loops").iterdir())]
    return [b"# %d\n" % number + loops[number % len(loops)] for number in range(50)]


def simulated(folder: Path, tests: int) -> Path:
    return write_drive_folder(
        folder,
        seed=3,
        scenario="wearing",
        tests=tests,
        hours=300.0,
        cycles=2,
        samples=300,
        max_torque_Nm=63.0,
        one_sided=False,
        command="tests",
    )


def upload(api: object, record: bytes, hours: float, drive: str = "cell3-axis2") -> object:
    return api.post(
        f"/drives/{drive}/tests",
        files={"file": ("loop.csv", record)},
        data={"service_hours": str(hours)},
    )


def test_a_killed_server_and_worker_lose_no_accepted_upload(
    tmp_path: Path, started: list[Server], records: list[bytes]
) -> None:
    server = Server(tmp_path, seconds=PATIENCE)
    started.append(server.start())
    with server.api() as api:
        assert api.post("/drives", json=DRIVE).status_code == 201
        taken = [upload(api, record, hours) for hours, record in enumerate(records[:3])]
        numbers = [one.json()["job_id"] for one in taken]
        wait_for_jobs(api, numbers[:1], ("running",))
    server.kill()  # its worker notices that it is alone, and ends with its job
    server.settings["STAND_IN_SECONDS"] = "0"
    server.start()
    with server.api() as api:
        states = wait_for_jobs(api, numbers)
        assert [one["state"] for one in states] == ["done"] * 3
        summary = api.get("/drives/cell3-axis2").json()
        assert [test["service_hours"] for test in summary["tests"]] == [0.0, 1.0, 2.0]
    assert server.stop() == 0


def test_a_terminal_that_closes_ends_server_and_worker_as_their_owner_would(
    tmp_path: Path, started: list[Server], records: list[bytes]
) -> None:
    """The server told a mistake, and the worker went on with a job that another could take up."""
    server = Server(tmp_path, "--workers", "0", seconds=PATIENCE)
    started.append(server.start())
    with (
        server.api() as api,
        subprocess.Popen(
            [*HDPROG, "worker", "--data", str(tmp_path)],
            env={**os.environ, **server.settings},
            preexec_fn=hear_it_close,
        ) as worker,
    ):
        try:
            assert api.post("/drives", json=DRIVE).status_code == 201
            numbers = [upload(api, records[0], 0.0).json()["job_id"]]
            wait_for_jobs(api, numbers, ("running",))
            worker.send_signal(signal.SIGHUP)
            assert worker.wait(PATIENCE / 4) == 0
        finally:
            worker.kill()
        [left] = wait_for_jobs(api, numbers, ("queued",))
        assert left["error"] is None
    assert server.stop(signal.SIGHUP) == 0


def test_fifty_uploads_at_once(tmp_path: Path, started: list[Server], records: list[bytes]) -> None:
    server = Server(tmp_path)
    started.append(server.start())
    with server.api() as api:
        for number in range(2):
            content = {**DRIVE, "drive": {**DRIVE["drive"], "id": f"d{number}"}}
            assert api.post("/drives", json=content).status_code == 201

        def one(number: int) -> object:
            return upload(api, records[number], float(number), f"d{number % 2}")

        with ThreadPoolExecutor(50) as pool:
            taken = list(pool.map(one, range(50)))
        assert [answer.status_code for answer in taken] == [202] * 50
        numbers = [answer.json()["job_id"] for answer in taken]
        assert len({answer.json()["test_uid"] for answer in taken}) == 50
        states = wait_for_jobs(api, numbers)
        assert {state["state"] for state in states} == {"done"}
        for number in range(2):
            assert len(api.get(f"/drives/d{number}").json()["tests"]) == 25


def test_a_flood_is_cut_off(tmp_path: Path, started: list[Server]) -> None:
    server = Server(tmp_path, "--max-upload-mb", "2")
    started.append(server.start())
    with server.api() as api:
        assert api.post("/drives", json=DRIVE).status_code == 201
        token = api.headers["authorization"]
    head = (
        "POST /api/v1/drives/cell3-axis2/tests HTTP/1.1\r\nHost: x\r\n"
        f"Authorization: {token}\r\nContent-Type: multipart/form-data; boundary=x\r\n"
        "Transfer-Encoding: chunked\r\n\r\n"
    )
    first = b'--x\r\nContent-Disposition: form-data; name="file"; filename="a.csv"\r\n\r\n'
    sent = 0
    with socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as line:
        line.sendall(head.encode() + b"%x\r\n%s\r\n" % (len(first), first))
        try:
            while sent < 2 << 30:
                line.sendall(b"10000\r\n" + b"1" * 65536 + b"\r\n")
                sent += 65536
        except OSError:
            pass  # the server has hung up
        else:
            raise AssertionError("the server took 2 GB in")
    assert sent < 50_000_000
    left = sum(path.stat().st_size for path in tmp_path.rglob("*.part"))
    assert left < 4_000_000


def test_one_true_fit(tmp_path: Path, started: list[Server]) -> None:
    folder = simulated(tmp_path / "drive", tests=1)
    hdprog("store", "import", str(folder), "--data", str(tmp_path / "data"))
    from hdprog.store.audit import COMMAND_LINE
    from hdprog.store.settings import ServiceSettings, change_settings
    from hdprog.store.store import open_store

    with open_store(tmp_path / "data") as store, store.writing() as session:
        change_settings(session, COMMAND_LINE, ServiceSettings(quick=True))
    server = Server(tmp_path / "data", seconds=None)
    started.append(server.start())
    with server.api() as api:
        ends = time.monotonic() + PATIENCE
        while not (summary := api.get("/drives/drive").json())["tests"]:
            assert time.monotonic() < ends
            time.sleep(0.5)
        assert summary["schema"] == "hdprog.summary/1"
        assert len(summary["tests"]) == 1
        assert summary["forecast"][-1]["quantity"] == "first_limit"
        report = api.get("/drives/drive/report")
        assert "hdprog report" in report.text
        assert "sandbox" in report.headers["content-security-policy"]
        [line] = api.get("/drives").json()["drives"]
        assert line["status"] == summary["verdict"]["status"]


def test_no_login_stays_on_this_machine(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="expected a loopback address"):
        hdprog("serve", "--no-login", "--host", "0.0.0.0", "--data", str(tmp_path))


@pytest.mark.parametrize("host", ["127.0.0.1", "no.such.invalid"])
def test_an_address_that_cannot_be_listened_on_is_refused_at_once(
    host: str, tmp_path: Path
) -> None:
    """It ended with 3, bad input, after workers were started, in the words of a log."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        done = CliRunner().invoke(
            app, ["serve", "--host", host, "--port", port, "--data", str(tmp_path / "data")]
        )
    assert done.exit_code == 2
    assert f"found {host}, port {port}, where nothing can listen" in done.output
    assert not (tmp_path / "data").exists()


def test_the_demonstration_is_not_among_ones_own_drives(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="expected neither"):
        hdprog("serve", "--demo", "--data", str(tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_accounts_and_tokens_from_the_command_line(tmp_path: Path) -> None:
    data = ("--data", str(tmp_path))
    assert "role admin" in hdprog("user", "add", "ada", *data, given=PASSWORD + "\n")
    assert "role viewer" in hdprog(
        "user", "add", "bob", "--role", "viewer", *data, given=PASSWORD + "\n"
    )
    printed = hdprog("token", "add", "rig", *data)
    assert printed.startswith("hdp_")
    assert len(printed.split()) == 1
    assert PASSWORD not in hdprog("user", "list", *data)
