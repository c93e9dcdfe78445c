"""Workers beside the server are begun, and begun again."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import threading
from collections.abc import Sequence

import pytest

from hdprog.service import crew as beside


def test_a_machine_without_memory_for_a_moment_gets_its_worker_later(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The thread that minds a worker ended: records were taken in and never analysed."""
    tries, up = 0, threading.Event()

    def started(options: Sequence[str]) -> subprocess.Popen[bytes]:
        nonlocal tries
        tries += 1
        if tries == 1:
            raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM))
        waits = subprocess.Popen([sys.executable, "-c", "input()", *options], stdin=subprocess.PIPE)
        up.set()
        return waits

    monkeypatch.setattr(beside, "_started", started)
    monkeypatch.setattr(beside, "_REST_SECONDS", 0.01)
    monkeypatch.setattr(beside, "_LOOK_SECONDS", 0.01)
    with beside.crew(1, []):
        assert up.wait(60.0)
    assert "could not be started" in caplog.text
