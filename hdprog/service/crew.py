"""The workers that `hdprog serve` has beside it: started, started again when one dies, ended."""

from __future__ import annotations

import logging
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

log = logging.getLogger("hdprog.service")
_LOOK_SECONDS = 1.0
_REST_SECONDS = 5.0  # before a worker that died soon is started again
_END_SECONDS = 10.0


@contextmanager
def crew(count: int, options: Sequence[str]) -> Iterator[None]:
    """Keep workers running for the block.

    Parameters
    ----------
    count : number of workers
    options : of `hdprog worker`
    """
    stop = threading.Event()
    threads = [
        threading.Thread(target=_keep_running, args=(options, stop), daemon=True)
        for _ in range(count)
    ]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        stop.set()
        for thread in threads:
            thread.join(_END_SECONDS + _REST_SECONDS)


def _keep_running(options: Sequence[str], stop: threading.Event) -> None:
    while not stop.is_set():
        begun = time.monotonic()
        try:
            process = _started(options)
        except OSError as error:  # no memory or no process left: there may be, later
            log.warning("a worker could not be started, trying again: %s", error)
            stop.wait(_REST_SECONDS)
            continue
        while process.poll() is None and not stop.wait(_LOOK_SECONDS):
            pass
        if process.poll() is None:
            process.terminate()
            try:
                process.wait(_END_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        elif time.monotonic() - begun < _REST_SECONDS:
            stop.wait(_REST_SECONDS)


def _started(options: Sequence[str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [
            sys.executable,
            "-c",
            "from hdprog.cli import main; main()",
            "worker",
            "--until-input-ends",
            *options,
        ],
        stdin=subprocess.PIPE,  # never written to; it ends when this server does
        start_new_session=True,  # Ctrl-C reaches the server, which then ends its workers
    )
