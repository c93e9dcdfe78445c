"""A worker: takes one job after the other from the queue and has each run in its own process."""

from __future__ import annotations

import logging
import math
import os
import signal
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NoReturn

from dbos import DBOS
from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session

from hdprog.service.job_process import JobProcess
from hdprog.service.queue import NAME, WORKFLOW, Queue, configuration, quiet_logs
from hdprog.service.slots import Places, places_of, taken_slot
from hdprog.store import jobs, workers
from hdprog.store.database import patiently
from hdprog.store.store import Store

log = logging.getLogger("hdprog.worker")
_SWEEP_SECONDS = 5.0
_LOOK_SECONDS = 0.5


@dataclass(frozen=True)
class WorkerSettings:
    """How a worker works.

    Attributes
    ----------
    data : the store's folder
    url : address of the store's database, None for the one in the folder
    processes : that a job may use
    dask : address of a Dask scheduler that the fits go to, None to fit here
    """

    data: Path
    url: str | None
    processes: int
    dask: str | None = None


def work(settings: WorkerSettings, stop: threading.Event) -> None:
    """Take jobs until told to stop.

    Parameters
    ----------
    settings : how
    stop : set to make an end; the job under way goes back to the queue
    """
    quiet_logs()
    store = Store(settings.data, settings.url)
    store.prepare()
    queue = Queue(store.database.url)
    queue.prepare()
    places = places_of(store)
    with taken_slot(places) as (name, hold):
        DBOS(config=configuration(store.database.url, name))

        # The store counts how often a job is begun: pages show what it holds.
        @DBOS.workflow(name=WORKFLOW, max_recovery_attempts=None)
        def analyse(job_id: str) -> str:
            return _run_next(store, settings, job_id, stop)

        DBOS.listen_queues([NAME])
        DBOS.launch()
        log.info("worker %s takes jobs", name)
        pulse = _Pulse(store, name)
        try:
            pulse.beat()
            while not stop.wait(_SWEEP_SECONDS):
                if hold.lost():
                    _end_at_once(name)
                _take_over(queue, places, name)
                pulse.beat()
        finally:
            pulse.end()
            # A job that was interrupted stays taken in this place's name: who takes the place next
            # takes the job up again.
            DBOS.destroy(destroy_registry=True)
            queue.close()
            store.close()


class _Pulse:
    """Lets pages know that this worker lives; a database that is away costs no more than a mark."""

    def __init__(self, store: Store, name: str) -> None:
        self._store, self._name = store, name
        self._last = -math.inf

    def beat(self) -> None:
        """Leave a mark, if the last one is old enough."""
        if time.monotonic() - self._last >= workers.MARK_SECONDS:
            self._write(workers.mark)
            self._last = time.monotonic()

    def end(self) -> None:
        """Take the mark away."""
        self._write(workers.forget)

    def _write(self, change: Callable[[Session, str], None]) -> None:
        with suppress(DBAPIError), self._store.writing() as session:
            change(session, self._name)


def _take_over(queue: Queue, places: Places, own: str) -> None:
    """Let the jobs wait again whose workers are gone."""
    try:
        for name in sorted(queue.holders() - {own}):
            with places.hold(name) as hold:
                if hold is not None and (count := queue.release(name)):
                    log.warning("%d job(s) of worker %s, which is gone, wait again", count, name)
    except DBAPIError as error:
        log.warning("the database does not answer: %s", error.orig)


def _end_at_once(name: str) -> NoReturn:
    """End this process and its job as a kill would: the job is another worker's by now."""
    log.error(
        "worker %s was cut off from the database, and another has taken its place; it ends here "
        "and may be started again",
        name,
    )
    os._exit(1)


class _InterruptedError(BaseException):
    """The worker was told to stop while a job was under way."""


def _run_next(store: Store, settings: WorkerSettings, entry: str, stop: threading.Event) -> str:
    """Run the next job of a drive to its end; whatever goes wrong becomes words in its row.

    Parameters
    ----------
    entry : a job of the drive, as it stands in the queue: each is a turn for the oldest open one
    """

    def go_on() -> None:
        if stop.is_set():
            raise _InterruptedError

    def start() -> tuple[str, int] | str:
        with store.writing() as session:
            job = jobs.next_job(session, entry)
            if job is None:
                return "none open"  # cancelled, or done together with an earlier one
            began = job.started_at
            number = jobs.start(session, job)
            if job.lost >= jobs.MOST_LOST:
                job.started_at = began  # no try begins now: what was asked for since has its own
                jobs.fail(session, job, number, _LOST)
                return "failed"
            return job.id, number

    started = patiently(start, go_on)
    if isinstance(started, str):
        return started
    job_id, attempt = started

    def is_wanted() -> bool:
        with store.reading() as session:
            job = jobs.find_job(session, job_id)
            return job is not None and job.state == "running" and job.attempt == attempt

    def fail(words: str) -> None:
        with store.writing() as session:
            job = jobs.find_job(session, job_id, alone=True)
            if job is not None:
                jobs.fail(session, job, attempt, words)

    def set_back() -> None:
        with suppress(DBAPIError), store.writing() as session:
            job = jobs.find_job(session, job_id, alone=True)
            if job is not None:
                jobs.set_back(session, job, attempt)

    log.info("job %s, attempt %d", job_id, attempt)
    try:
        with JobProcess(settings, job_id, attempt) as process:
            while process.wait(_LOOK_SECONDS) is None:
                if not patiently(is_wanted, go_on):
                    return "cancelled"
        if process.code != 0:
            patiently(partial(fail, _words(process.code)), go_on)
            return "failed"
    except OSError as error:
        patiently(partial(fail, _NOT_STARTED.format(error)), go_on)
        return "failed"
    except _InterruptedError:
        # systemd may end a service of which the machine killed a process for want of memory: that
        # is counted as a worker lost.
        if process.code != -signal.SIGKILL:
            set_back()
        raise
    return "done"


_NOT_STARTED = (
    "No process could be started for this job ({}), most often for want of memory or of processes "
    "of the machine. Start the job again."
)


_LOST = (
    f"The worker of this job was killed {jobs.MOST_LOST} times, or cut off from the database, "
    "before the job was done; most often for want of memory. Give the machine more memory, or "
    "remove the drive's longest record and upload a shorter one; then start the job again. The "
    "machine's log says what ended the worker."
)


def _words(code: int | None) -> str:
    """Say what an exit code without words of its own means."""
    if code is not None and code < 0:
        return (
            f"The process of this job was ended by signal {-code} of the machine, most often for "
            "want of memory. Start the job again; if it ends so again, give the machine more "
            "memory or upload a shorter record."
        )
    return (
        f"The process of this job ended with code {code} and left no words. Start the job again; "
        "the worker's log holds what it printed."
    )
