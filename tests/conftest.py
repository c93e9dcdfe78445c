"""Fixtures that several folders of tests share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


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
    from hdprog.parallel import hold_blas_to_one_thread

    hold_blas_to_one_thread()
