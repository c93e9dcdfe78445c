"""The command line: one file a command; numerics are imported inside the command that runs."""

from __future__ import annotations

import gc

from hdprog.cli.app import app
from hdprog.cli.plain_output import write_plainly_where_needed


def main() -> None:
    """Run the `hdprog` command on the arguments of this process, then exit with its code."""
    # Nearly all that a command makes it needs to its end, and looking for cycles in it is in vain.
    gc.set_threshold(100_000, 20, 50)
    write_plainly_where_needed()
    try:
        app(prog_name="hdprog")
    finally:
        # Whatever is left goes with the process; looking through it for cycles takes a second.
        gc.freeze()


__all__ = ["app", "main"]
