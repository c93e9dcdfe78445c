"""A required test that is skipped fails the run, with and without worker processes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def run(folder: Path, mark: str, *options: str, required: bool = True) -> int:
    """Run pytest on one passing test and one skipped one that carries `mark`; give its code."""
    (folder / "pytest.ini").write_text(
        "[pytest]\nmarkers =\n    measured\n    chromium\n    nginx\n    postgres\n    other\n",
        encoding="utf-8",
    )
    (folder / "test_it.py").write_text(
        "import pytest\n\ndef test_passes(): pass\n\n"
        f"@pytest.mark.{mark}\ndef test_skips(): pytest.skip('absent')\n",
        encoding="utf-8",
    )
    settings = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST")}
    settings |= {"PYTHONPATH": str(ROOT), "HDPROG_REQUIRE_ALL": "1" if required else ""}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "tests.plugins.require_all", *options]
    return subprocess.run(
        command, cwd=folder, env=settings, capture_output=True, check=False
    ).returncode


@pytest.mark.parametrize("mark", ["measured", "chromium", "nginx", "postgres"])
def test_skipped_required_test_fails(tmp_path: Path, mark: str) -> None:
    assert run(tmp_path, mark) == pytest.ExitCode.TESTS_FAILED


def test_skipped_in_a_worker_fails_too(tmp_path: Path) -> None:
    assert run(tmp_path, "measured", "-n", "2") == pytest.ExitCode.TESTS_FAILED


def test_other_skips_pass(tmp_path: Path) -> None:
    assert run(tmp_path, "other") == pytest.ExitCode.OK


def test_nothing_is_required_unless_asked(tmp_path: Path) -> None:
    assert run(tmp_path, "measured", required=False) == pytest.ExitCode.OK
