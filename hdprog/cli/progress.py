"""Progress on standard error, when a person is looking at it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Report = Callable[[str, int, int], None]
"""`report(stage, done, total)`: `done` of `total` steps of a stage are done."""


@contextmanager
def progress(*, quiet: bool) -> Iterator[Report | None]:
    """Show a bar for each stage while the block runs, then clear it.

    Parameters
    ----------
    quiet : bool
        Show nothing.

    Yields
    ------
    Report or None
        What to call as the work goes on; None when standard error is no terminal or `quiet`.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    # Imported here: Rich takes longer to import than a short command takes to run.
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TaskID,
        TextColumn,
        TimeElapsedColumn,
    )

    bars = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),  # Rich itself heeds NO_COLOR
        transient=True,
    )
    stages: dict[str, TaskID] = {}

    def report(stage: str, done: int, total: int) -> None:
        if stage not in stages:
            stages[stage] = bars.add_task(stage, total=total)
        bars.update(stages[stage], completed=done, total=total)

    with bars:
        yield report
