"""Workers as on other machines: a host name each, and the shared folder at a place of their own."""

from __future__ import annotations

import functools
import os
import shlex
import subprocess
import sys
from pathlib import Path

from tests.web.server import STAND_IN


@functools.cache
def unshare() -> tuple[str, ...]:
    """Find how this machine lets us have names and mounts of our own; empty where it does not."""
    for more in ((), ("--map-root-user",)):
        command = ("unshare", *more, "--uts", "--mount")
        try:
            # What is needed, tried: a name, and a mount.
            done = subprocess.run(
                [*command, "sh", "-c", "hostname tried && mount -t tmpfs none /mnt"],
                capture_output=True,
                check=False,
            )
        except OSError:
            return ()
        if done.returncode == 0:
            return command
    return ()


class Machine:
    """A worker on a machine of its own, which sees the shared folder elsewhere than we do.

    Parameters
    ----------
    name : of the machine
    folder : shared
    seen_at : where the machine has it; the folder's own place is empty there
    database : address of the database
    hold : jobs last while this file, which must not lie below `folder`, is there
    """

    def __init__(self, name: str, folder: Path, seen_at: Path, database: str, hold: Path) -> None:
        seen_at.mkdir()
        worker = [sys.executable, "-c", "from hdprog.cli import main; main()", "worker"]
        at, place = shlex.quote(str(folder)), shlex.quote(str(seen_at))
        steps = [
            f"hostname {name}",
            f"mount --bind {at} {place}",
            f"mount -t tmpfs none {at}",
            f"exec {shlex.join([*worker, '--data', str(seen_at), '--processes', '1'])}",
        ]
        self.process = subprocess.Popen(
            [*unshare(), "sh", "-c", " && ".join(steps)],
            env={
                **os.environ,
                "PYTHONPATH": str(STAND_IN),
                "STAND_IN_HOLD": str(hold),
                "HDPROG_DATABASE": database,
            },
        )

    def kill(self) -> None:
        """End the worker, and nothing but it, as a power cut would."""
        self.process.kill()
        self.process.wait()
