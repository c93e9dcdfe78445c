"""The process that a job runs in: ended with all its children when it is called off."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
from types import TracebackType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hdprog.service.worker import WorkerSettings

_NICENESS = 10  # pages come before fits


class JobProcess:
    """A job's process, for the length of a block; it does not outlive its worker.

    Parameters
    ----------
    settings : of the worker
    job_id, attempt : which job, and the how manieth try
    """

    def __init__(self, settings: WorkerSettings, job_id: str, attempt: int) -> None:
        self._order = {
            "data": str(settings.data),
            "url": settings.url,
            "processes": settings.processes,
            "dask": settings.dask,
            "job": job_id,
            "attempt": attempt,
        }
        self.code: int | None = None

    def __enter__(self) -> JobProcess:
        """Start it; the order goes in by its standard input, which then stays open."""
        self._process = subprocess.Popen(
            [sys.executable, "-m", "hdprog.service.analyse"],
            stdin=subprocess.PIPE,
            start_new_session=True,
        )
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(json.dumps(self._order).encode() + b"\n")
            self._process.stdin.flush()
        return self

    def wait(self, seconds: float) -> int | None:
        """Wait for its end; None where it has not come in that time."""
        try:
            self.code = self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            return None
        return self.code

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it and its children, if they have not ended by themselves."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.close()


def take_order() -> dict[str, object]:
    """Read, in a job's process, what it shall do, and end with its worker from then on."""
    os.nice(_NICENESS)
    # Read past Python's own buffer: a thread that waits in it holds a lock, which processes that
    # are forked meanwhile would wait for without end.
    pipe, line = sys.stdin.fileno(), b""
    while not line.endswith(b"\n"):
        piece = os.read(pipe, 1)
        if not piece:
            sys.exit(1)  # the worker is gone before it said what to do
        line += piece

    def watch() -> None:
        os.read(pipe, 1)  # returns when the worker is gone, however it went
        os.killpg(os.getpgrp(), signal.SIGKILL)

    threading.Thread(target=watch, daemon=True).start()
    order: dict[str, object] = json.loads(line)
    return order
