"""Whole runs of the shipped drives with undeclared effects: found, followed, forecast, written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import hdprog
from hdprog import workflow
from hdprog.shipped import shipped
from hdprog.trend import fitting
from tests.drive_folders import subset_of
from tests.hasty import HASTY, SHORT
from tests.reporting.page import Page

DRIVES = Path(str(shipped("datasets"))) / "undeclared-effect"
TESTS = ["t01", "t04", "t06"]


@pytest.mark.parametrize(
    ("name", "verdict", "origins"),
    [
        ("two-effects", "explained", {"kinematic_error": "rig", "thermal_drift": "rig"}),
        ("on-no-list", "unexplained", {"unknown": "rig"}),
    ],
)
def test_a_drive_is_run_whole_with_what_it_lacks(
    name: str,
    verdict: str,
    origins: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Effects are found before a loop is sampled; of the forecast, only that it is there.
    monkeypatch.setattr(workflow, "QUICK", SHORT)
    monkeypatch.setattr(fitting, "JOINT_QUICK", HASTY)
    folder = subset_of(DRIVES / name, tmp_path / "drive", TESTS)
    outcome = hdprog.run(folder, quick=True, seed=3)
    outcome.write(tmp_path / "out")
    found: dict[str, Any] = json.loads((tmp_path / "out" / "explain.json").read_text("utf-8"))
    assert found["verdict"] == verdict
    assert {effect["id"]: effect["origin"] for effect in found["effects"]} == origins
    assert found["after"]["rmse_rad"] < 0.8 * found["before"]["rmse_rad"]
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    assert [test["test_id"] for test in summary["tests"]] == TESTS
    assert summary["forecast"]
    page = Page((tmp_path / "out" / "report.html").read_text("utf-8"))
    assert page.faults == []
