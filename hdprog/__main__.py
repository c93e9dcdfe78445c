"""The command, as the script `hdprog` and as `python -m hdprog`."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the `hdprog` command, also where it is interrupted while it is still imported."""
    try:
        from hdprog.cli import main as command
    except KeyboardInterrupt:
        print("Interrupted before anything was begun.", file=sys.stderr)
        raise SystemExit(130) from None  # as in hdprog.cli.exits, which may not be imported yet
    command()


if __name__ == "__main__":
    main()
