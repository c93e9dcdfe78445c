"""Drive folders made out of some tests of another one."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path


def subset_of(drive: Path, folder: Path, tests: Sequence[str]) -> Path:
    """Copy a few tests of a drive folder; returns the new folder."""
    (folder / "loops").mkdir(parents=True)
    shutil.copy(drive / "drive.toml", folder)
    header, *rows = (drive / "tests.csv").read_text("utf-8").splitlines()
    chosen = [row for row in rows if row.split(",")[0] in tests]
    (folder / "tests.csv").write_text("\n".join([header, *chosen]) + "\n", "utf-8")
    for test in tests:
        shutil.copy(drive / "loops" / f"{test}.csv", folder / "loops")
    return folder
