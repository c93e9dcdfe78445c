"""The shipped drives with undeclared effects: found, followed, forecast, written."""

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


@pytest.fixture(autouse=True)
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Effects are found before a loop is sampled; of the forecast, only that it is there."""
    monkeypatch.setattr(workflow, "QUICK", SHORT)
    monkeypatch.setattr(fitting, "JOINT_QUICK", HASTY)


def told(out: Path) -> dict[str, Any]:
    """What explain.json says, beside a report without a fault."""
    assert Page((out / "report.html").read_text("utf-8")).faults == []
    found: dict[str, Any] = json.loads((out / "explain.json").read_text("utf-8"))
    assert found["after"]["rmse_rad"] < 0.8 * found["before"]["rmse_rad"]
    return found


def origins(found: dict[str, Any]) -> dict[str, str]:
    return {effect["id"]: effect["origin"] for effect in found["effects"]}


def test_a_drive_is_run_whole_with_what_it_lacks(tmp_path: Path) -> None:
    folder = subset_of(DRIVES / "two-effects", tmp_path / "drive", TESTS)
    hdprog.run(folder, quick=True, seed=3).write(tmp_path / "out")
    found = told(tmp_path / "out")
    assert found["verdict"] == "explained"
    assert origins(found) == {"kinematic_error": "rig", "thermal_drift": "rig"}
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    assert [test["test_id"] for test in summary["tests"]] == TESTS
    assert summary["forecast"]


def test_a_drive_is_explained_by_what_no_list_has(tmp_path: Path) -> None:
    folder = subset_of(DRIVES / "on-no-list", tmp_path / "drive", TESTS)
    hdprog.explain(folder, quick=True, seed=3).write(tmp_path / "out")
    found = told(tmp_path / "out")
    assert found["verdict"] == "unexplained"
    assert origins(found) == {"unknown": "rig"}
