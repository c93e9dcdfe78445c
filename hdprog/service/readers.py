"""Processes that read uploaded records, kept ready: a hostile file ruins one of them, no more."""

from __future__ import annotations

import contextlib
import json
import queue
import subprocess
import sys
import threading
from collections.abc import Mapping
from importlib.resources import as_file
from pathlib import Path
from typing import Any

from hdprog.service.readout import ReadOut, refused
from hdprog.shipped import shipped

_SECONDS = 60.0
_BYTES_A_SECOND = 500_000  # that are read at least, of files that take longer than that
_START_SECONDS = 120.0
_LARGE = 32 << 20  # bytes of a file after which a reader is renewed, to give its memory back


class Readers:
    """A few reader processes.

    Parameters
    ----------
    count : how many records are read at the same time
    """

    def __init__(self, count: int) -> None:
        self._free: queue.SimpleQueue[_Reader] = queue.SimpleQueue()
        self._all = [_Reader() for _ in range(count)]
        for reader in self._all:
            self._free.put(reader)

    def read(self, path: Path, name: str, content: Mapping[str, Any]) -> ReadOut:
        """Read a record, within limits of time and memory.

        Parameters
        ----------
        path : of the bytes
        name : what the user calls the file
        content : of the drive's drive.toml

        Returns
        -------
        ReadOut
            What goes over a limit is a problem like any other.
        """
        reader = self._free.get()
        try:
            order = {"path": str(path), "name": name, "content": dict(content)}
            size = path.stat().st_size
            seconds = max(_SECONDS, size / _BYTES_A_SECOND)
            answer = reader.ask(order, seconds)
            if size > _LARGE:
                reader.stop()
        finally:
            self._free.put(reader)
        if answer is None:
            return refused(
                name,
                f"a record that was not read within {seconds:.0f} s and the memory allowed",
                "one that can be",
            )
        return ReadOut(tuple(answer["problems"]), answer["quality"], answer["picture"])

    def warm_up(self) -> None:
        """Start the processes and have them load what they need, by reading a shipped record."""
        with as_file(shipped("datasets") / "healthy-csf-25-80" / "loops" / "t01.csv") as path:
            order = {"path": str(path), "name": path.name, "content": {"drive": {"id": "warm"}}}
            for reader in [self._free.get() for _ in self._all]:
                reader.ask(order, _START_SECONDS)
                self._free.put(reader)

    def stop(self) -> None:
        """End the processes."""
        for reader in self._all:
            reader.stop()


class _Reader:
    """One process, started when it is first asked and again after it was ended."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def ask(self, order: Mapping[str, Any], seconds: float) -> dict[str, Any] | None:
        """Give an order and wait for the answer; None, and the process ended, without one."""
        process = self._running()
        assert process.stdin is not None
        assert process.stdout is not None
        timer = threading.Timer(seconds, process.kill)
        timer.start()
        line = ""
        try:
            with contextlib.suppress(OSError):
                process.stdin.write(json.dumps(order) + "\n")
                process.stdin.flush()
                line = process.stdout.readline()
        finally:
            timer.cancel()
        if not line.endswith("\n"):
            self.stop()
            return None
        answer: dict[str, Any] = json.loads(line)
        return answer

    def stop(self) -> None:
        """End the process."""
        process, self._process = self._process, None  # another thread may end it too
        if process is None:
            return
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):
                if stream is not None:
                    stream.close()

    def _running(self) -> subprocess.Popen[str]:
        if self._process is None or self._process.poll() is not None:
            self.stop()
            self._process = subprocess.Popen(
                [sys.executable, "-m", "hdprog.service.reader"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                encoding="utf-8",
                start_new_session=True,  # Ctrl-C reaches the server, which then ends its readers
            )
        return self._process
