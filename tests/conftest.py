"""Fixtures that several folders of tests share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

_LONGEST = (
    "trend/test_joint_refit.py",
    "workflow/test_undeclared_drives.py",
    "reporting/test_browser.py",
    "cli/test_growing_effect.py",
    "trend/test_fleet.py",
    "trend/test_temperature_of_drives.py",
    "trend/test_trend.py",
    "workflow/test_run.py",
    "service/test_queue.py",
    "comparison/test_recovery.py",
    "web/test_server.py",
    "web/test_story.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put files that take longest first: begun last, one would keep all but its worker waiting."""
    root = Path(__file__).parent
    place = {root / name: number for number, name in enumerate(_LONGEST)}
    items.sort(key=lambda item: place.get(item.path, len(place)))


@pytest.fixture(scope="session")
def measured_data() -> Path:
    """Give the folder of measured records, which the project does not ship."""
    named = os.environ.get("HDPROG_MEASURED_DATA")
    folder = Path(named) if named else Path(__file__).parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(
            f"no measured records: {folder} is no folder; set HDPROG_MEASURED_DATA to theirs"
        )
    return folder


@pytest.fixture(scope="session", autouse=True)
def _one_thread_of_linear_algebra() -> None:
    """Threads of small matrix products only get in each other's way beside parallel tests."""
    from hdprog.parallel import prepare_numerics

    prepare_numerics()
