"""The queue: kept with what asked for it, in order, and taken over from the dead."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hdprog.service import worker
from hdprog.service.queue import Queue
from hdprog.service.slots import places_of
from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import find_drive
from hdprog.store.store import Store
from hdprog.store.tables import JobRow
from hdprog.store.uploads import TestFacts
from tests.service.places import is_free
from tests.store.postgres import cut_all
from tests.store.samples import add_bytes, add_sample
from tests.web.server import PATIENCE

STAND_IN = Path(__file__).parents[1] / "web" / "stand_in"


@pytest.fixture
def queue(store: Store) -> Iterator[Queue]:
    made = Queue(store.database.url)
    made.prepare()
    yield made
    made.close()


@pytest.fixture
def sqlite_queue(sqlite_store: Store) -> Iterator[Queue]:
    made = Queue(sqlite_store.database.url)
    made.prepare()
    yield made
    made.close()


class Worker:
    """A worker process, with the stand-in for the fits; its jobs last while a file is there."""

    def __init__(self, store: Store, hold: Path | None = None) -> None:
        settings = {"PYTHONPATH": str(STAND_IN)}
        if hold is not None:
            hold.touch()
            settings["STAND_IN_HOLD"] = str(hold)
        command = [sys.executable, "-c", "from hdprog.cli import main; main()", "worker"]
        self.process = subprocess.Popen(
            [*command, "--data", str(store.files.root), "--database", store.database.url],
            env={**os.environ, **settings},
        )

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait(PATIENCE)


@pytest.fixture
def hold(tmp_path: Path) -> Path:
    return tmp_path / "hold"


@pytest.fixture
def workers() -> Iterator[list[Worker]]:
    started: list[Worker] = []
    yield started
    for one in started:
        one.kill()


def wait_for(what: Callable[[], bool]) -> None:
    ends = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < ends, "it did not come about in time"
        time.sleep(0.1)


def ask(store: Store, queue: Queue, name: str, data: bytes, hours: float) -> str:
    """Add a test to a drive, made where it is not, and ask for its analysis."""
    with store.writing() as session:
        drive = find_drive(session, name) or add_sample(session, name)
        test, _ = add_bytes(session, store.files, drive, data, TestFacts(hours))
        job = jobs.add_job(session, COMMAND_LINE, drive, test)
        queue.enqueue(session, job)
        return job.id


def undone(store: Store, queue: Queue) -> None:
    """Ask for an analysis in a transaction that comes to nothing."""
    with store.writing() as session:
        drive = add_sample(session, "gone")
        queue.enqueue(session, jobs.add_job(session, COMMAND_LINE, drive, None))
        raise ZeroDivisionError


def job(store: Store, number: str) -> JobRow:
    with store.reading() as session:
        found = jobs.find_job(session, number)
        assert found is not None
        return found


def test_a_job_runs_and_its_result_is_kept(
    store: Store, queue: Queue, workers: list[Worker]
) -> None:
    number = ask(store, queue, "a", b"1", 5.0)
    workers.append(Worker(store))
    wait_for(lambda: job(store, number).state == "done")
    with store.reading() as session:
        drive = find_drive(session, "a")
        assert drive is not None
        assert drive.status == "plan"
        assert drive.analysis_id is not None
        assert (store.files.analysis(drive.analysis_id) / "report.html").is_file()


def test_work_that_was_not_committed_is_not_queued(
    store: Store, queue: Queue, workers: list[Worker]
) -> None:
    with pytest.raises(ZeroDivisionError):
        undone(store, queue)
    number = ask(store, queue, "a", b"1", 5.0)
    workers.append(Worker(store))
    wait_for(lambda: job(store, number).state == "done")


def test_a_drives_jobs_run_in_order_and_not_side_by_side(
    store: Store, queue: Queue, workers: list[Worker], hold: Path
) -> None:
    numbers = [ask(store, queue, "a", b"1", 1.0)]
    workers += [Worker(store, hold), Worker(store, hold)]
    wait_for(lambda: job(store, numbers[0]).stage == "fitting")
    numbers += [ask(store, queue, "a", bytes([65 + n]), 2.0 + n) for n in range(3)]
    other = ask(store, queue, "b", b"z", 1.0)
    hold.unlink()
    wait_for(lambda: all(job(store, n).state == "done" for n in [*numbers, other]))
    first, *rest = [job(store, number) for number in numbers]
    assert first.finished_at is not None
    for one in rest:
        # The last three came while the first ran: one analysis holds them all.
        assert one.analysis_id == rest[0].analysis_id != first.analysis_id
        assert one.started_at is None or one.started_at >= first.finished_at


def test_of_jobs_asked_for_together_the_first_runs_first(
    store: Store, queue: Queue, workers: list[Worker], hold: Path
) -> None:
    numbers = [ask(store, queue, "a", bytes([65 + n]), 2.0 + n) for n in range(8)]
    workers.append(Worker(store, hold))
    wait_for(lambda: any(job(store, number).state == "running" for number in numbers))
    assert job(store, numbers[0]).state == "running"
    hold.unlink()
    wait_for(lambda: all(job(store, number).state == "done" for number in numbers))


def test_a_killed_workers_job_is_taken_up_again(
    store: Store, queue: Queue, workers: list[Worker], hold: Path
) -> None:
    number = ask(store, queue, "a", b"1", 5.0)
    workers.append(Worker(store, hold))
    wait_for(lambda: job(store, number).state == "running")
    workers[0].kill()
    workers.append(Worker(store))
    wait_for(lambda: job(store, number).state == "done")
    assert job(store, number).attempt == 2


def test_a_living_worker_takes_over_from_a_dead_one(
    sqlite_store: Store, sqlite_queue: Queue, workers: list[Worker], hold: Path
) -> None:
    store, queue = sqlite_store, sqlite_queue
    number = ask(store, queue, "a", b"1", 5.0)
    workers.append(Worker(store, hold))
    wait_for(lambda: job(store, number).state == "running")
    workers.append(Worker(store))  # in a place of its own
    wait_for(lambda: len(list(store.files.workers.glob("*.lock"))) == 2)
    workers[0].kill()
    wait_for(lambda: job(store, number).state == "done")


def test_a_stopped_worker_gives_its_job_back(
    sqlite_store: Store, sqlite_queue: Queue, workers: list[Worker], hold: Path
) -> None:
    store, queue = sqlite_store, sqlite_queue
    number = ask(store, queue, "a", b"1", 5.0)
    workers.append(Worker(store, hold))
    wait_for(lambda: job(store, number).state == "running")
    workers[0].stop()
    assert job(store, number).state == "queued"
    workers.append(Worker(store))
    wait_for(lambda: job(store, number).state == "done")
    assert job(store, number).lost == 0


def test_cancelling_ends_the_work_and_retrying_does_it(
    sqlite_store: Store, sqlite_queue: Queue, workers: list[Worker], hold: Path
) -> None:
    store, queue = sqlite_store, sqlite_queue
    number = ask(store, queue, "a", b"1", 5.0)
    workers.append(Worker(store, hold))
    wait_for(lambda: job(store, number).state == "running")
    with store.writing() as session:
        assert jobs.cancel(session, COMMAND_LINE, session.get_one(JobRow, number))
    assert job(store, number).cancelled
    with store.writing() as session:
        again = session.get_one(JobRow, number)
        assert jobs.reopen(session, COMMAND_LINE, again)
        queue.enqueue(session, again)
    hold.unlink()
    wait_for(lambda: job(store, number).state == "done")
    assert job(store, number).attempt == 2


def test_a_jobs_process_ends_with_a_worker_that_gave_no_order() -> None:
    command = [sys.executable, "-m", "hdprog.service.analyse"]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, timeout=PATIENCE, check=False)
    assert done.returncode == 1


@pytest.mark.parametrize(
    ("name", "words"), [("fails", "found a drive that fails"), ("dies", "ended with code 9")]
)
def test_what_goes_wrong_is_said(
    sqlite_store: Store, sqlite_queue: Queue, workers: list[Worker], name: str, words: str
) -> None:
    store, queue = sqlite_store, sqlite_queue
    number = ask(store, queue, name, b"1", 5.0)
    fine = ask(store, queue, "fine", b"2", 5.0)
    workers.append(Worker(store))
    wait_for(lambda: job(store, fine).state == "done")
    wait_for(lambda: job(store, number).state == "failed")
    assert words in str(job(store, number).error)


@pytest.mark.postgres
def test_a_job_outlives_a_break_of_all_connections(
    postgres_url: str, tmp_path: Path, workers: list[Worker], hold: Path
) -> None:
    store = Store(tmp_path / "data", postgres_url)
    store.prepare()
    queue = Queue(store.database.url)
    queue.prepare()
    number = ask(store, queue, "a", b"1", 5.0)
    workers.append(Worker(store, hold))
    wait_for(lambda: job(store, number).state == "running")
    [place] = queue.holders()
    cut_all(postgres_url)
    wait_for(lambda: not is_free(places_of(store), place))
    cut_all(postgres_url)
    hold.unlink()
    wait_for(lambda: job(store, number).state == "done")
    assert job(store, number).attempt == 1
    later = ask(store, queue, "b", b"2", 5.0)
    wait_for(lambda: job(store, later).state == "done")
    queue.close()
    store.close()


def test_a_job_whose_process_cannot_be_started_fails_in_words(
    sqlite_store: Store, sqlite_queue: Queue, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It had stayed "running" for ever."""

    def refused(*_: object) -> None:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    number = ask(sqlite_store, sqlite_queue, "a", b"1", 5.0)
    monkeypatch.setattr(worker, "JobProcess", refused)
    settings = worker.WorkerSettings(sqlite_store.files.root, None, 1)
    assert worker._run_next(sqlite_store, settings, number, threading.Event()) == "failed"
    found = job(sqlite_store, number)
    assert found.state == "failed"
    assert "No process could be started" in (found.error or "")


def test_a_job_that_kills_its_workers_is_begun_three_times(store: Store, queue: Queue) -> None:
    """It had been begun a hundred times where the machine lacked memory, and then never ended."""
    number = ask(store, queue, "a", b"1", 5.0)
    for lost in range(jobs.MOST_LOST):
        with store.writing() as session:
            killed = session.get_one(JobRow, number)
            jobs.start(session, killed)
            assert killed.lost == lost
    settings = worker.WorkerSettings(store.files.root, store.database.url, 1)
    assert worker._run_next(store, settings, number, threading.Event()) == "failed"
    found = job(store, number)
    assert found.state == "failed"
    assert "was killed 3 times" in (found.error or "")
    with store.writing() as session:
        again = session.get_one(JobRow, number)
        assert jobs.reopen(session, COMMAND_LINE, again)
        for _ in range(5):  # a worker that is told to stop is not killed
            jobs.set_back(session, again, jobs.start(session, again))
        assert (again.state, again.lost) == ("queued", 0)


@pytest.mark.parametrize(
    ("code", "state"), [(-signal.SIGTERM, "queued"), (-signal.SIGKILL, "running")]
)
def test_a_job_that_the_machine_killed_counts_though_its_worker_is_told_to_stop(
    sqlite_store: Store,
    sqlite_queue: Queue,
    monkeypatch: pytest.MonkeyPatch,
    code: int,
    state: str,
) -> None:
    """So systemd ends a service for want of memory: it was begun again without end."""
    stop = threading.Event()

    class Ended(worker.JobProcess):
        def __enter__(self) -> Ended:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def wait(self, _: float) -> int:
            stop.set()
            self.code = code
            return code

    number = ask(sqlite_store, sqlite_queue, "a", b"1", 5.0)
    monkeypatch.setattr(worker, "JobProcess", Ended)
    settings = worker.WorkerSettings(sqlite_store.files.root, None, 1)
    with pytest.raises(worker._InterruptedError):
        worker._run_next(sqlite_store, settings, number, stop)
    assert job(sqlite_store, number).state == state
