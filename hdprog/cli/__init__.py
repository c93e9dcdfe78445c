"""The command line: one file a command; numerics are imported inside the command that runs."""

from __future__ import annotations

from hdprog.cli.app import app
from hdprog.cli.plain_output import write_plainly_where_needed


def main() -> None:
    """Run the `hdprog` command on the arguments of this process, then exit with its code."""
    write_plainly_where_needed()
    app(prog_name="hdprog")


__all__ = ["app", "main"]
