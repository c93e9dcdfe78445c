"""A drive folder through the workflow, as jobs run it."""

from __future__ import annotations

from pathlib import Path

import pytest

from hdprog.errors import BadInputError
from hdprog.service.drive_run import Order, run_here
from tests.drive_folders import subset_of

DRIVE = Path(__file__).parents[2] / "datasets" / "healthy-csf-25-80"


def test_what_is_wrong_is_told_without_the_folder_of_the_job(tmp_path: Path) -> None:
    """Which is gone by then, and says nothing to whoever reads it on a page."""
    folder = subset_of(DRIVE, tmp_path / "drive", ["t10"])
    text = (folder / "drive.toml").read_text("utf-8")
    later = text.replace("horizon_hours = 20000.0", "horizon_hours = 800.0")
    (folder / "drive.toml").write_text(later, "utf-8")
    with pytest.raises(BadInputError) as caught:
        run_here(Order(folder, tmp_path / "out", True, 1, "tests"), lambda _stage, _done: None)
    assert str(caught.value).startswith("drive.toml, [forecast] horizon_hours: found a horizon of")
