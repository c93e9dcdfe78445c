"""`hdprog backtest` from folders to scores."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

import pytest

from hdprog import backtesting
from hdprog.backtesting import backtest
from hdprog.config import read_drive
from hdprog.data.truth_file import read_truth
from hdprog.errors import BadInputError
from hdprog.shipped import shipped
from tests.cli.conftest import Invoke
from tests.drive_folders import subset_of
from tests.hasty import SHORT
from tests.reporting.page import Page

DRIVE = Path(str(shipped("datasets"))) / "wearing-csf-25-80"


def subset(folder: Path, *tests: str) -> Path:
    """Copy a few tests of the shipped drive, without its truth."""
    return subset_of(DRIVE, folder, tests)


@pytest.mark.skipif(
    sys.platform != "linux", reason="the shorter plan reaches forked worker processes only"
)
def test_a_fleet_with_one_drive_that_can_be_read(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(backtesting, "QUICK", SHORT)
    subset(tmp_path / "axis1", "t05", "t10")
    subset(tmp_path / "fleet" / "axis2", "t05")
    (tmp_path / "fleet" / "axis1").symlink_to(tmp_path / "axis1")
    (tmp_path / "hdprog-backtest-fleet").mkdir()
    (tmp_path / "hdprog-backtest-fleet" / "backtest.json").write_text("{}", "utf-8")
    (tmp_path / "hdprog-backtest-fleet" / "report.pdf").write_text("of before", "utf-8")
    shown = invoke("backtest", "fleet", "--quick", "--workers", "2", "--seed", "3")
    # A plan this short converges nowhere, and the whole says so.
    assert shown.exit_code == 4, shown.stderr
    assert "Not converged" in shown.stdout
    assert "Left out: axis2: fleet/axis2/tests.csv: found one service hour" in shown.stdout
    assert "Report: hdprog-backtest-fleet/report.html" in shown.stdout
    folder = tmp_path / "hdprog-backtest-fleet"
    assert sorted(file.name for file in folder.iterdir()) == ["backtest.json", "report.html"]
    found = json.loads((folder / "backtest.json").read_text("utf-8"))
    assert found["schema"] == "hdprog.backtest/1"
    assert found["seed"] == 3
    assert [one["folder"] for one in found["left_out"]] == ["axis2"]
    (drive,) = found["drives"]
    assert drive["tests_not_converged"] == ["t05", "t10"]
    (origin,) = drive["origins"]
    assert (origin["test_id"], origin["tests_known"]) == ("t05", 1)
    assert len(origin["forecasts"]) == 3
    for forecast in origin["forecasts"]:
        # The true crossings lie past 900 h, and no truth is in the folder: nothing was seen.
        assert forecast["crossed_at_hours"] is None
        assert forecast["seen_until_hours"] == 900
        assert 0 <= forecast["probability_crossed_by_then"] < 1
        assert not forecast["from_truth"]
    assert len(origin["later_tests"]) == 3
    assert found["pooled"]["crossings"]["forecasts"] == 3
    assert not found["pooled"]["crossings"]["enough_for_a_verdict"]
    text = (folder / "report.html").read_text("utf-8")
    assert len(text) < 2e6
    page = Page(text)
    assert page.faults == []
    assert "No limit was passed by 900 h" in page.text
    assert "too few for a verdict" in page.text
    assert "axis2" in page.text
    assert all(picture["alt"] for picture in page.pictures)
    assert len(page.pictures) == 3  # no crossing was seen: no alpha-lambda picture
    assert "hdprog backtest fleet --quick" in page.text


@pytest.mark.parametrize(("name", "begin"), [(".", ""), ("line1/axis1", "line1/axis1/")])
def test_files_are_named_by_their_path_from_the_folder_that_was_given(
    tmp_path: Path, name: str, begin: str
) -> None:
    read = backtesting._read(subset(tmp_path / "axis1", "t05", "t10"), name)
    assert list(read.files) == [begin + "loops/t05.csv", begin + "loops/t10.csv"]


def test_nothing_is_written_where_no_drive_can_be_read(invoke: Invoke, tmp_path: Path) -> None:
    subset(tmp_path / "fleet" / "axis2", "t05")
    subset(tmp_path / "fleet" / "axis3", "t05", "t10")
    (tmp_path / "fleet" / "axis3" / "loops" / "t10.csv").write_text("torque,angle\n", "utf-8")
    shown = invoke("backtest", "fleet", "--quick")
    assert shown.exit_code == 3
    assert "axis2" in shown.stderr
    assert "t10.csv" in shown.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fleet"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.partition("[[limits]]")[0], "no limit"),
        (lambda text: text.replace("horizon_hours = 20000.0", "horizon_hours = 800.0"), "axis1"),
        (lambda text: text.replace('"csf-25-80"', '"csf-25-81"'), "no prior called"),
    ],
)
def test_a_drive_that_cannot_be_backtested_is_refused(
    tmp_path: Path, change: object, words: str
) -> None:
    folder = subset(tmp_path / "axis1", "t05", "t10")
    text = (folder / "drive.toml").read_text("utf-8")
    (folder / "drive.toml").write_text(change(text), "utf-8")  # type: ignore[operator]
    with pytest.raises(BadInputError, match=words):
        backtest(folder, quick=True)


def test_a_folder_without_drives_and_no_folder(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"no drive\.toml in it or below it"):
        backtest(tmp_path)
    with pytest.raises(BadInputError, match="no such folder"):
        backtest(tmp_path / "nowhere")


def test_the_truth_is_read_in_both_forms(tmp_path: Path) -> None:
    drive = read_drive(DRIVE)
    lost, secant, width = drive.limits
    found = read_truth(DRIVE / "truth.json", drive)
    assert found is not None
    assert found.known_until == 20_000
    assert found.crossings == {lost: 1315, secant: 1435, width: 1600}
    path = tmp_path / "truth.json"
    assert read_truth(path, drive) is None
    entry = {
        "quantity": secant.quantity,
        "direction": "below",
        "limit": 13000.0,
        "at_torque_Nm": 14,
        "crossing_hours": None,
    }
    other = {"quantity": "lost_motion_arcmin", "direction": "above", "limit": 1.5}
    entries = [entry, other | {"at_torque_Nm": None, "crossing_hours": 700}]
    path.write_text(json.dumps({"limits": entries, "horizon_hours": 5000}), "utf-8")
    # The truth of another threshold is none of this limit's.
    found = read_truth(path, drive)
    assert found is not None
    assert (found.crossings, found.known_until) == ({secant: math.inf}, 5000)


@pytest.mark.parametrize("text", ["{", "[]", '{"crossing_hours": {"lost_motion_arcmin": "soon"}}'])
def test_a_truth_that_cannot_be_read_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "truth.json"
    path.write_text(text, "utf-8")
    with pytest.raises(BadInputError, match=r"truth\.json.*crossing_hours"):
        read_truth(path, read_drive(DRIVE))
