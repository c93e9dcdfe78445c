"""`hdprog fit --method paper`: the paper's identification beside the posterior."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hdprog import workflow
from hdprog.errors import UsageError
from hdprog.shipped import shipped
from tests.cli.conftest import Invoke
from tests.reporting.page import Page

DRIVE = Path(str(shipped("datasets"))) / "wearing-csf-25-80"
LOOP = DRIVE / "loops" / "t08.csv"


def test_the_point_estimate_stands_beside_the_posterior(invoke: Invoke) -> None:
    drive = str(DRIVE / "drive.toml")
    shown = invoke("fit", str(LOOP), "--drive", drive, "--quick", "--method", "paper", "--out", "x")
    assert shown.exit_code == 0, shown.stderr
    assert "own identification" in shown.stdout
    [test] = json.loads(Path("x/summary.json").read_text("utf-8"))["tests"]
    found = test["paper_identification"]
    assert set(found["parameters"]) == set(test["parameters"])
    assert set(found["figures"]) == set(test["figures"])
    fails = " ".join(found["where_it_fails"])
    assert "no error of its own" in fails
    assert "turn straight" in fails
    # The posterior beats it on its own criterion.
    assert found["rmse_rad"] > test["rmse_rad"]
    page = Page(Path("x/report.html").read_text("utf-8"))
    assert page.faults == []
    assert "The paper's own identification beside the posterior" in page.text
    assert "with other points" in page.text


def test_wrong_methods_are_refused(invoke: Invoke) -> None:
    shown = invoke("fit", str(LOOP), "--method", "eye")
    assert shown.exit_code == 2
    assert "expected posterior or paper" in shown.stderr
    shown = invoke("fit", str(LOOP), "--method", "paper", "--effects", "creep")
    assert shown.exit_code == 2
    assert "five points" in shown.stderr


def test_a_one_sided_record_leaves_nothing_behind(invoke: Invoke, tmp_path: Path) -> None:
    torque = np.concatenate([np.linspace(0, 60, 80), np.linspace(59, 0, 80)])
    rows = "\n".join(f"{t:.3f},{t / 2e4:.8f}" for t in torque)
    (tmp_path / "half.csv").write_text(f"torque_Nm,angle_rad\n{rows}\n", "utf-8")
    shown = invoke("fit", "half.csv", "--method", "paper")
    assert shown.exit_code == 3
    assert "two-sided" in shown.stderr
    assert not (tmp_path / "hdprog-half").exists()


def test_the_api_refuses_a_method_that_does_not_exist() -> None:
    with pytest.raises(UsageError, match="expected one of posterior, paper"):
        workflow._require_method("eye", ())
