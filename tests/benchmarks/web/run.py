"""Measure the upload page and write the results: ``python -m tests.benchmarks.web.run``."""

from __future__ import annotations

import argparse
import json
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import httpx2

from hdprog.service.importing import take_in_folder
from hdprog.service.queue import Queue
from hdprog.store.store import open_store
from tests.benchmarks.web.fleet import fill
from tests.web.server import PASSWORD, Server, hdprog, log_in

HERE = Path(__file__).parent
DATASETS = HERE.parents[2] / "datasets"
PAUSE = 0.02  # seconds between two pages, as of somebody who clicks fast


def quantiles(seconds: list[float]) -> dict[str, float]:
    """Sum times up in ms."""
    cuts = statistics.quantiles(seconds, n=20)
    return {
        "pages": len(seconds),
        "p50_ms": round(1e3 * statistics.median(seconds), 1),
        "p95_ms": round(1e3 * cuts[18], 1),
        "worst_ms": round(1e3 * max(seconds), 1),
    }


def timed(client: httpx2.Client, paths: list[str], going: Callable[[int], bool]) -> dict[str, Any]:
    """Load pages in turn while it goes on."""
    times: dict[str, list[float]] = {path: [] for path in paths}
    number = 0
    while going(number):
        path = paths[number % len(paths)]
        begun = time.perf_counter()
        answer = client.get(path)
        times[path].append(time.perf_counter() - begun)
        assert answer.status_code == 200, (path, answer.status_code)
        number += 1
        time.sleep(PAUSE)
    every = [one for found in times.values() for one in found]
    return {"all": quantiles(every), **{path: quantiles(found) for path, found in times.items()}}


def person(server: Server) -> httpx2.Client:
    """Log a browser in."""
    client = httpx2.Client(base_url=server.address, timeout=60)
    assert log_in(client, "ada").status_code == 303
    return client


def memory(server: Server) -> dict[str, float]:
    """Give the resident memory in MB of the server, its readers, its workers and their jobs."""
    assert server.process is not None
    found = {"server": 0.0, "readers": 0.0, "workers": 0.0, "jobs": 0.0}
    family = {server.process.pid}
    for folder in sorted(Path("/proc").glob("[0-9]*"), key=lambda one: int(one.name)):
        try:
            words = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            status = (folder / "status").read_text()
        except OSError:
            continue
        parent = int(status.partition("PPid:")[2].split()[0])
        if int(folder.name) not in family and parent not in family:
            continue
        family.add(int(folder.name))
        size = float(status.partition("VmRSS:")[2].split()[0]) / 1024
        if int(folder.name) == server.process.pid:
            found["server"] += size
        elif "hdprog.service.reader" in words:
            found["readers"] += size
        elif "hdprog.service.analyse" in words:
            found["jobs"] += size
        elif "worker" in words:
            found["workers"] += size
    return {name: round(size) for name, size in found.items()}


def while_fits_run(place: Path, seconds: float) -> dict[str, Any]:
    """Load pages without and with two true fits under way."""
    data = ("--data", str(place))
    hdprog("user", "add", "ada", *data, given=PASSWORD + "\n")
    server = Server(place, "--workers", "2", seconds=None).start()
    try:
        client = person(server)
        with open_store(place) as store:
            queue = Queue(store.database.url)
            for name in ("wearing-csf-25-80", "healthy-csf-25-80"):
                take_in_folder(store, queue, DATASETS / name)
            queue.close()
        jobs = httpx2.Client(base_url=f"{server.address}/api/v1", headers=server.api().headers)
        ends = time.monotonic() + 30
        paths = ["/", "/drives/wearing-csf-25-80", "/tests/t03", "/healthz", "/drives/new"]
        while jobs.get("/drives/healthy-csf-25-80").json()["waiting"] and time.monotonic() < ends:
            time.sleep(0.2)
            if _running(client):
                break
        stop = time.monotonic() + seconds
        busy = timed(client, paths, lambda _number: time.monotonic() < stop)
        used = memory(server)
        assert _running(client), "the fits had ended before the pages were measured"
    finally:
        server.kill()
    return {"pages_while_two_fits_run": busy, "memory_MB_while_two_fits_run": used}


def _running(client: httpx2.Client) -> bool:
    return client.get("/healthz").json()["open_jobs"] == 2


def uploads(place: Path, count: int) -> dict[str, Any]:
    """Upload records one after the other, then eight at a time; fits are left out."""
    server = Server(place, "--workers", "0").start()
    found: dict[str, Any] = {}
    record = (DATASETS / "wearing-csf-25-80" / "loops" / "t01.csv").read_bytes()
    try:
        with server.api() as api:
            api.post("/drives", json={"drive": {"id": "rig", "model": "CSF-25-80"}})

            def send(number: int) -> int:
                return api.post(
                    "/drives/rig/tests",
                    files={"file": ("t.csv", b"# %d\n" % number + record)},
                    data={"service_hours": str(number)},
                ).status_code

            assert send(-1 + 10_000) == 202  # the readers are warm from here on
            for clients in (1, 8):
                begun = time.perf_counter()
                with ThreadPoolExecutor(clients) as pool:
                    codes = list(pool.map(send, range(clients * 1000, clients * 1000 + count)))
                assert codes == [202] * count
                found[f"accepted_a_second_by_{clients}_at_a_time"] = round(
                    count / (time.perf_counter() - begun), 1
                )
            found["memory_MB"] = memory(server)
    finally:
        server.kill()
    return found


def large_fleet(place: Path, drives: int, tests: int) -> dict[str, Any]:
    """Load the fleet's page of a store with thousands of drives."""
    hdprog("user", "add", "ada", "--data", str(place), given=PASSWORD + "\n")
    fill(place, drives, tests)
    server = Server(place, "--workers", "0").start()
    try:
        client = person(server)
        paths = ["/", "/?page=60", "/?q=cell400", "/?status=good", "/drives/cell400-axis1"]
        return {
            "drives": drives,
            "tests_a_drive": tests,
            "database_MB": round((place / "hdprog.db").stat().st_size / 1e6),
            **timed(client, paths, lambda number: number < 40 * len(paths)),
        }
    finally:
        server.kill()


def written(results: dict[str, Any]) -> str:
    """Give the results as a page."""
    busy = results["pages_while_two_fits_run"]
    fleet = results["large_fleet"]
    lines = [
        "# The upload page, measured",
        "",
        f"Made by `{results['command']}` on {results['date']}, {results['cores']} cores, load "
        f"average {results['load_before']} before it began. Times are of whole answers over one "
        "connection.",
        "",
        "| while two fits run | answers | p50 ms | p95 ms | worst ms |",
        "|---|---|---|---|---|",
        *(_row(name, found) for name, found in busy.items()),
        "",
        f"| {fleet['drives']} drives with {fleet['tests_a_drive']} tests each "
        f"({fleet['database_MB']} MB) | answers | p50 ms | p95 ms | worst ms |",
        "|---|---|---|---|---|",
        *(_row(name, found) for name, found in fleet.items() if isinstance(found, dict)),
        "",
        "| | |",
        "|---|---|",
    ]
    up = results["uploads"]
    lines += [
        f"| uploads {name.replace('_', ' ')} | {up[name]} |" for name in up if "accepted" in name
    ]
    used = results["memory_MB_while_two_fits_run"]
    lines += [
        f"| resident MB of {name}, two fits running | {size} |" for name, size in used.items()
    ]
    lines += [
        f"| resident MB of {name}, after the uploads | {size} |"
        for name, size in up["memory_MB"].items()
    ]
    lines += [
        "",
        "Memory is the sum over processes and counts pages that they share more than once.",
        "",
    ]
    return "\n".join(lines)


def _row(name: str, found: dict[str, float]) -> str:
    cells = [found[key] for key in ("pages", "p50_ms", "p95_ms", "worst_ms")]
    return f"| `{name}` | " + " | ".join(map(str, cells)) + " |"


def main() -> None:
    """Measure all and write the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=40.0, help="of loading pages beside fits")
    parser.add_argument("--uploads", type=int, default=60)
    parser.add_argument("--drives", type=int, default=5000)
    parser.add_argument("--tests", type=int, default=20)
    asked = parser.parse_args()
    results: dict[str, Any] = {
        "schema": "hdprog.benchmark.web/1",
        "command": "python -m tests.benchmarks.web.run",
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "cores": len(os.sched_getaffinity(0)),
        "load_before": round(os.getloadavg()[0], 1),
    }
    with tempfile.TemporaryDirectory() as place:
        results |= while_fits_run(Path(place) / "fits", asked.seconds)
        results["uploads"] = uploads(Path(place) / "uploads", asked.uploads)
        results["large_fleet"] = large_fleet(Path(place) / "fleet", asked.drives, asked.tests)
    folder = HERE / "results"
    folder.mkdir(exist_ok=True)
    (folder / "summary.json").write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    (folder / "summary.md").write_text(written(results), "utf-8")
    print(written(results))


if __name__ == "__main__":
    main()
