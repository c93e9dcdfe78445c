"""Workers on other machines: a shared folder, PostgreSQL, and one machine that dies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from hdprog.service.queue import Queue
from hdprog.service.slots import DatabasePlaces
from hdprog.store.drives import find_drive
from hdprog.store.store import Store
from tests.service.machines import Machine, unshare
from tests.service.places import is_free
from tests.service.test_queue import ask, job, wait_for

# Where the machine forbids names and mounts of our own, no run can demand this test.
pytestmark = (
    pytest.mark.postgres
    if unshare()
    else pytest.mark.skip(reason="unshare --uts --mount is not permitted here")
)


@pytest.fixture
def machines() -> Iterator[dict[str, Machine]]:
    started: dict[str, Machine] = {}
    yield started
    for one in started.values():
        one.kill()


def test_a_machine_takes_over_from_a_dead_one_and_from_no_living_one(
    postgres_url: str, tmp_path: Path, machines: dict[str, Machine]
) -> None:
    store = Store(tmp_path / "data", postgres_url)
    store.prepare()
    queue = Queue(store.database.url)
    queue.prepare()
    places = DatabasePlaces(store.database.url)
    hold, unheld = tmp_path / "hold", tmp_path / "unheld"
    hold.touch()

    long = ask(store, queue, "long", b"1", 5.0)
    machines["rig-a"] = Machine("rig-a", store.files.root, tmp_path / "a", postgres_url, hold)
    wait_for(lambda: job(store, long).state == "running")
    assert queue.holders() == {"rig-a-1"}
    machines["rig-b"] = Machine("rig-b", store.files.root, tmp_path / "b", postgres_url, unheld)
    for number in range(3):  # the other machine sweeps between them and leaves the living alone
        short = ask(store, queue, f"short{number}", b"2", 5.0)
        wait_for(lambda number=short: job(store, number).state == "done")
        assert not is_free(places, "rig-a-1")
    assert (job(store, long).state, job(store, long).attempt) == ("running", 1)

    machines["rig-a"].kill()  # its job's process, told nothing, ends with it
    wait_for(lambda: job(store, long).state == "done")
    assert job(store, long).attempt == 2
    with store.reading() as session:
        drive = find_drive(session, "long")
        assert drive is not None
        assert drive.analysis_id is not None
        assert (store.files.analysis(drive.analysis_id) / "report.html").is_file()
    assert hold.exists()
    queue.close()
    store.close()


def test_a_machine_without_the_shared_folder_is_refused(
    postgres_url: str, tmp_path: Path, machines: dict[str, Machine]
) -> None:
    store = Store(tmp_path / "data", postgres_url)
    store.prepare()
    empty = tmp_path / "empty"
    empty.mkdir()
    machines["rig-c"] = Machine("rig-c", empty, tmp_path / "c", postgres_url, tmp_path / "hold")
    assert machines["rig-c"].process.wait() != 0
    store.close()
