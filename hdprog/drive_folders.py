"""Drive folders below a folder."""

from __future__ import annotations

import os
from pathlib import Path

from hdprog.atomic import is_aside


def drive_folders(path: Path, results: Path | None = None) -> list[Path]:
    """Find the folders with a drive.toml, links followed, each once; none that is unfinished.

    Parameters
    ----------
    path : Path
        Where to look, and below.
    results : Path or None
        A folder below `path` in which nothing is looked for.

    Returns
    -------
    list of Path
        By name; the same on every machine.
    """
    return folders_with("drive.toml", path, results)


def folders_with(name: str, path: Path, left_out: Path | None = None) -> list[Path]:
    """Find the folders with a file, as `drive_folders` does those of drives."""
    left_out = None if left_out is None else left_out.resolve()
    found: list[Path] = []
    seen: set[Path] = set()
    for place, inner, files in os.walk(path, followlinks=True):
        here = Path(place)
        real = here.resolve()
        if real in seen or (real == left_out and here != path):
            inner.clear()
            continue
        seen.add(real)
        inner[:] = [one for one in inner if not is_aside(one)]
        inner.sort()  # of two names of a folder the same one on every machine
        if name in files:
            found.append(here)
    return sorted(found)
