"""Build the example reports, their index page and README's pictures of them.

    python -m tests.example_reports [--data DIR] [--only NAME ...]

DIR holds the measured records (folders cycloidal-torque-ramps and torsion-spring), which are no
part of the project; without it the reports of measured records stay as they are. Takes some
minutes on one core.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

from hdprog.reporting.build import environment
from tests.example_reports import screenshots
from tests.example_reports.build import REPORTS, Built, build, kept
from tests.example_reports.examples import EXAMPLES

_PAGE = Path(__file__).with_name("index.html")


def processor_seconds() -> float:
    """Processor time of the commands so far, which does not depend on what else runs."""
    spent = os.times()
    return spent.children_user + spent.children_system


def write_index(built: list[Built]) -> None:
    """Write the page that lists the examples."""
    template = environment().from_string(_PAGE.read_text("utf-8"))
    text = template.render(title="Example reports – hdprog", built=built)
    (REPORTS / "index.html").write_text(text, "utf-8")


def main() -> None:
    """Build what is asked for, then the index and the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder of the measured records")
    parser.add_argument(
        "--only",
        nargs="*",
        choices=["index", *(example.name for example in EXAMPLES)],
        help="build these anew and keep the others (index: the index and the pictures alone)",
    )
    options = parser.parse_args()
    listed = []
    for example in EXAMPLES:
        wanted = options.only is None or example.name in options.only
        if wanted and (options.data is not None or not example.source):
            started, before = time.perf_counter(), processor_seconds()
            listed.append(build(example, options.data))
            spent = time.perf_counter() - started
            cpu = processor_seconds() - before
            print(f"{example.name}: {spent:.0f} s, {cpu:.0f} s of processor time", flush=True)
        elif (found := kept(example)) is not None:
            listed.append(found)
    write_index(listed)
    screenshots.take()


if __name__ == "__main__":
    main()
