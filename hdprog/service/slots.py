"""Places of workers: each holds a lock that the machine frees when the worker dies."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

_MOST = 512


@contextmanager
def taken_slot(folder: Path) -> Iterator[str]:
    """Take the first free place of this machine for the block; gives its name.

    A worker that starts again takes the place, and so the work, of the one that was killed.
    """
    host = re.sub(r"[^A-Za-z0-9-]", "-", socket.gethostname())[:40] or "worker"
    for number in range(1, _MOST):
        name = f"{host}-{number}"
        lock = FileLock(folder / f"{name}.lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            continue
        try:
            yield name
        finally:
            lock.release()
        return
    raise RuntimeError(f"more than {_MOST} workers on one machine")


def abandoned(folder: Path, own: str) -> Iterator[str]:
    """Yield the places that no living worker holds, each held while it is looked at."""
    for path in sorted(folder.glob("*.lock")):
        if path.stem == own:
            continue
        lock = FileLock(path)
        try:
            lock.acquire(timeout=0)
        except Timeout:
            continue
        try:
            yield path.stem
        finally:
            lock.release()
