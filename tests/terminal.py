"""Commands that hear of their terminal closing, wherever the tests run."""

from __future__ import annotations

import signal


def hear_it_close() -> None:
    """Undo what nohup does, in a new process: it leaves SIGHUP ignored."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
