"""`hdprog worker`: takes jobs of the upload service, on this machine or another."""

from __future__ import annotations

import os
import signal
import threading
from typing import Annotated

import typer

from hdprog.cli.exits import ending_signals
from hdprog.cli.web_extra import DaskAddress, Data, DatabaseUrl, data_folder, needs_web


@needs_web
def worker(
    data: Data = None,
    database: DatabaseUrl = None,
    processes: Annotated[
        int | None,
        typer.Option("--processes", min=1, help="Processes that a job may use (default: cores)."),
    ] = None,
    dask: DaskAddress = None,
    until_input_ends: Annotated[
        bool,
        typer.Option("--until-input-ends", help="Stop when standard input ends, however it does."),
    ] = False,
) -> None:
    """Take jobs of the upload service until stopped.

    `hdprog serve` starts workers of its own; more may run on other machines that reach the same
    database and data folder. One job at a time; what a killed worker leaves is taken up again.
    """
    import logging

    from hdprog.parallel import cores
    from hdprog.service.worker import WorkerSettings, work

    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(name)s: %(message)s")
    logging.getLogger("hdprog").setLevel(logging.INFO)
    stop = threading.Event()
    for sign in (signal.SIGINT, *ending_signals()):
        signal.signal(sign, lambda _number, _frame: stop.set())
    if until_input_ends:
        threading.Thread(target=_wait_for_end, args=(stop,), daemon=True).start()
    work(WorkerSettings(data_folder(data), database, processes or cores(), dask), stop)


def _wait_for_end(stop: threading.Event) -> None:
    """Wait for the end of standard input, past Python's buffer and its lock."""
    while os.read(0, 1024):
        pass
    stop.set()
