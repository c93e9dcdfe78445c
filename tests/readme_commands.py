"""The commands that README.md shows: print one, or run them and refresh the output shown.

    python tests/readme_commands.py --print demo      the shell line under `<!-- command: demo -->`
    python tests/readme_commands.py --update          rewrite the output in the console blocks

Needs only the standard library, so that it runs before anything is installed.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
WIDTH = 100
NAMED = re.compile(r"<!-- command: (?P<name>[\w-]+) -->\n```sh\n(?P<lines>.*?)```", re.DOTALL)
CONSOLE = re.compile(r"```console\n(?P<lines>.*?)```", re.DOTALL)


def named_commands(text: str) -> dict[str, str]:
    """Read the shell lines that a `command` comment names."""
    return {match["name"]: match["lines"].strip() for match in NAMED.finditer(text)}


def console_commands(text: str) -> list[str]:
    """Read the `$ ` lines of the console blocks, in order."""
    return [
        line.removeprefix("$ ")
        for match in CONSOLE.finditer(text)
        for line in match["lines"].splitlines()
        if line.startswith("$ ")
    ]


def wrapped(output: str) -> str:
    """Go on with long lines on the next, drop trailing space and the empty lines at the end."""
    lines = [line.rstrip() for line in output.rstrip().splitlines()]
    shown = [
        textwrap.fill(line, WIDTH, subsequent_indent="    ") if len(line) > WIDTH else line
        for line in lines
    ]
    return "".join(f"{line}\n" for line in shown)


def updated(text: str, run: Callable[[str], str]) -> str:
    """Put what `run` gives for each command of the console blocks below that command."""

    def refresh(match: re.Match[str]) -> str:
        commands = [line for line in match["lines"].splitlines() if line.startswith("$ ")]
        shown = "".join(f"{line}\n{wrapped(run(line.removeprefix('$ ')))}" for line in commands)
        return f"```console\n{shown}```"

    return CONSOLE.sub(refresh, text)


def run_in(folder: Path) -> Callable[[str], str]:
    """Run commands in `folder` with this interpreter's scripts first on the path."""
    scripts = str(Path(sys.executable).parent)
    settings = {
        **os.environ,
        "PATH": os.pathsep.join([scripts, os.environ.get("PATH", "")]),
        "NO_COLOR": "1",
    }

    def run(command: str) -> str:
        done = subprocess.run(
            ["bash", "-c", command],
            cwd=folder,
            env=settings,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            sys.exit(f"{command!r} ended with code {done.returncode}:\n{done.stdout}")
        return done.stdout

    return run


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    chosen = parser.add_mutually_exclusive_group(required=True)
    chosen.add_argument("--print", dest="name", help="print the command of this name")
    chosen.add_argument("--update", action="store_true", help="rewrite the output in README.md")
    options = parser.parse_args()
    text = README.read_text(encoding="utf-8")
    if options.update:
        with tempfile.TemporaryDirectory() as scratch:
            for folder in ("datasets", "priors"):
                Path(scratch, folder).symlink_to(ROOT / folder)
            text = updated(text, run_in(Path(scratch)))
        README.write_text(text, encoding="utf-8")
        return
    commands = named_commands(text)
    if options.name not in commands:
        sys.exit(f"README.md names {', '.join(commands)}, not {options.name!r}.")
    print(commands[options.name])


if __name__ == "__main__":
    main()
