"""A PostgreSQL server of the tests' own, in a folder that goes with it."""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def programs() -> Path | None:
    """Find the folder of initdb and postgres, the newest of Debian's; None where there is none."""
    debian = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=_version)
    found = str(debian[-1]) if debian else shutil.which("initdb")
    return None if found is None else Path(found).parent


def _version(path: Path) -> float:
    return float(path.parts[-3])


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def _unprivileged() -> int | None:
    """Choose whom the server runs as, since it refuses to run as root; None for ourselves."""
    if os.getuid() != 0:
        return None
    for name in ("postgres", "nobody"):
        try:
            return pwd.getpwnam(name).pw_uid
        except KeyError:
            continue
    raise RuntimeError("no account to run PostgreSQL as: expected postgres or nobody")


def _quick_place() -> str | None:
    """Choose memory over a disk where there is enough: every database is some 300 files."""
    shared = Path("/dev/shm")
    if shared.is_dir() and shutil.disk_usage(shared).free > 4 << 30:
        return str(shared)
    return None


@contextmanager
def running(binaries: Path) -> Iterator[str]:
    """Run a server for the block; gives the address of its first database."""
    user, port = _unprivileged(), free_port()
    place = Path(tempfile.mkdtemp(prefix="hdprog-postgres-", dir=_quick_place()))
    if user is not None:
        os.chown(place, user, -1)
    initdb = [str(binaries / "initdb"), "-D", str(place / "data"), "-U", "tester", "-A", "trust"]
    subprocess.run(
        [*initdb, "-E", "UTF8", "--no-sync"], check=True, capture_output=True, user=user, cwd="/"
    )
    options = {
        "listen_addresses": "127.0.0.1",
        "port": port,
        "unix_socket_directories": place,
        "fsync": "off",
        "max_connections": 200,
    }
    command = [str(binaries / "postgres"), "-D", str(place / "data")]
    for name, value in options.items():
        command += ["-c", f"{name}={value}"]
    log = (place / "log").open("wb")
    server = subprocess.Popen(command, stdout=log, stderr=log, user=user, cwd="/")
    try:
        _wait(port, server)
        yield f"postgresql://tester@127.0.0.1:{port}/postgres"
    finally:
        server.send_signal(signal.SIGQUIT)  # at once: nothing of it is kept
        try:
            server.wait(20)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()
        log.close()
        shutil.rmtree(place, ignore_errors=True)


def _wait(port: int, server: subprocess.Popen[bytes]) -> None:
    import psycopg

    ends = time.monotonic() + 300
    while time.monotonic() < ends:
        if server.poll() is not None:
            raise RuntimeError("PostgreSQL ended while it started")
        try:
            psycopg.connect(f"postgresql://tester@127.0.0.1:{port}/postgres").close()
        except psycopg.OperationalError:
            time.sleep(0.1)
        else:
            return
    raise RuntimeError("PostgreSQL did not answer within 300 s")


def cut_all(url: str) -> None:
    """Cut all connections to a database, as a restart of its server does; wait until they are."""
    import psycopg

    with psycopg.connect(url, autocommit=True) as connection:
        connection.execute(
            "SELECT pg_terminate_backend(pid, 10000) FROM pg_stat_activity "
            "WHERE datname = current_database() AND pid <> pg_backend_pid()"
        )
