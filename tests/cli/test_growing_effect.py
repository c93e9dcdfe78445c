"""Play that grows or comes at once: found, followed, and the limit judged with it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from hdprog import workflow
from hdprog.cli.exits import ExitCode
from hdprog.trend import fitting
from tests.cli.conftest import Invoke
from tests.hasty import HASTY, SHORT
from tests.independent.loops import programme, record_loop, worn_parameters, write_csv
from tests.independent.simulator import ARCMIN, true_figures

HOURS = (0.0, 500.0, 1000.0, 1500.0)
GROWN = (0.0, 1 / 3, 2 / 3, 1.0)
PLAY = 2e-4  # rad to either side in the last test
LIMIT = 2.0

DRIVE = f"""\
[drive]
id = "axis"
model = "CSF-25-80"
ratio = 80
alpha_deg = 30.0
rated_torque_Nm = 63.0
[noise]
torque_resolution_Nm = 0.1
angle_resolution_rad = 9.77e-6
[[limits]]
quantity = "lost_motion_arcmin"
above = {LIMIT}
[forecast]
horizon_hours = 6000.0
"""


def write_drive(
    folder: Path, hours_of: Sequence[float] = HOURS, shares: Sequence[float] = GROWN
) -> float:
    """Tests by the independent simulator, with shares of the play; the last's lost motion [′]."""
    (folder / "loops").mkdir(parents=True)
    (folder / "drive.toml").write_text(DRIVE, "utf-8")
    lines = ["test_id,file,service_hours"]
    for number, (hours, share) in enumerate(zip(hours_of, shares, strict=True)):
        rng = np.random.default_rng(20 + number)
        worn = worn_parameters(0.05 + 0.3 * hours / hours_of[-1])
        segments = programme("two-sided", 63.0, 20.0, rng)
        # Sizes are root mean squares, and outside its narrow zone play is its size all over.
        effects = {"backlash": PLAY * share} if share else {}
        record = record_loop(worn, segments, 400, rng, effects=effects)
        write_csv(record, folder / "loops" / f"t{number}.csv")
        lines.append(f"t{number},loops/t{number}.csv,{hours}")
    (folder / "tests.csv").write_text("\n".join(lines) + "\n", "utf-8")
    return true_figures(worn)["lost_motion_arcmin"] + 2 * PLAY / ARCMIN


def test_play_that_grows_is_followed_and_counts_once(invoke: Invoke, tmp_path: Path) -> None:
    lost_motion = write_drive(tmp_path / "axis")
    # On two cores fits come back from other processes, and are to be the same as at home.
    shown = invoke("run", "axis", "--quick", "--seed", "1", "--out", "found")
    assert shown.exit_code == 0, shown.stderr
    summary = json.loads((tmp_path / "found" / "summary.json").read_text("utf-8"))
    explained = json.loads((tmp_path / "found" / "explain.json").read_text("utf-8"))
    (found,) = explained["effects"]
    assert (found["id"], found["origin"]) == ("backlash", "wear")
    assert explained["after"]["rmse_rad"] <= explained["before"]["rmse_rad"]
    trend = summary["trend"]
    assert trend["followed_effects"] == ["backlash"]
    assert not [text for text in trend["warnings"] if "lost motion" in text]
    course = trend["figures"]["lost_motion_arcmin"]
    now = course["hours"].index(HOURS[-1])
    assert course["q05"][now] < lost_motion < course["q95"][now]
    assert course["q95"][now] < 1.2 * lost_motion


def test_play_that_comes_at_once_is_a_step_and_no_wear(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sampled shortly, by themselves and together: a step is told by the loops' modes."""
    monkeypatch.setattr(workflow, "QUICK", SHORT)
    monkeypatch.setattr(fitting, "JOINT_QUICK", HASTY)
    hours = (0.0, 300.0, 600.0, 900.0, 1500.0)
    lost_motion = write_drive(tmp_path / "axis", hours, (0, 0, 1, 1, 1))
    shown = invoke("run", "axis", "--quick", "--seed", "1", "--out", "found")
    assert shown.exit_code == ExitCode.NOT_CONVERGED, shown.stderr
    summary = json.loads((tmp_path / "found" / "summary.json").read_text("utf-8"))
    explained = json.loads((tmp_path / "found" / "explain.json").read_text("utf-8"))
    trend = summary["trend"]
    assert trend["followed_effects"] == ["backlash"]
    (sudden,) = trend["sudden_effects"]
    assert sudden == {"effect": "backlash", "between_tests": ["t1", "t2"], "came": True}
    assert [effect["origin"] for effect in explained["effects"]] == ["unclear"]
    assert any("Backlash came at once between tests t1" in text for text in trend["warnings"])
    course = trend["figures"]["lost_motion_arcmin"]
    before, after, now = (course["hours"].index(hour) for hour in (300.0, 600.0, 1500.0))
    assert course["q05"][now] < lost_motion < course["q95"][now]
    step = course["q50"][after] - course["q50"][before]
    assert abs(step * ARCMIN / (2 * PLAY) - 1.0) < 0.15
