"""Closing the loop on the shipped drives with undeclared effects, blind, from file to files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hdprog
from hdprog.errors import UsageError
from hdprog.outcome import ExplainOutcome
from hdprog.shipped import shipped
from tests.reporting.page import Page

DRIVES = Path(str(shipped("datasets"))) / "undeclared-effect"


def explained(folder: str, test: str) -> ExplainOutcome:
    drive = hdprog.read_drive(DRIVES / folder / "drive.toml")
    loop = hdprog.read_loop(DRIVES / folder / "loops" / f"{test}.csv", drive=drive)
    return hdprog.explain(loop, drive, seed=1, quick=True)


@pytest.fixture(name="creeping", scope="module")
def creeping_fixture() -> ExplainOutcome:
    return explained("one-effect", "t01")


@pytest.fixture(name="written", scope="module")
def written_fixture(creeping: ExplainOutcome, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("explain") / "out"
    creeping.write(folder, command="hdprog explain t01.csv")
    return folder


def test_the_effect_is_named_and_the_error_falls_to_the_noise(creeping: ExplainOutcome) -> None:
    assert creeping.verdict == "explained"
    [effect] = creeping.effects
    assert effect.id == "creep"
    assert effect.elpd_gain > 4
    assert effect.elpd_gain > 2 * effect.elpd_se
    assert creeping.after.rmse_rad < 0.5 * creeping.before.rmse_rad
    assert creeping.after.heldout_rmse_rad < 0.6 * creeping.before.heldout_rmse_rad
    assert abs(creeping.after.lag1) < 0.3
    assert creeping.tests[0].effects == ("creep",)
    assert creeping.converged


def test_the_files_hold_what_the_contract_asks_for(written: Path) -> None:
    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    text = (written / "explain.json").read_text("utf-8")
    found: dict[str, Any] = json.loads(text, parse_constant=refuse)
    assert found["schema"] == "hdprog.explain/1"
    assert found["verdict"] == "explained"
    assert set(found["before"]) == set(found["after"])
    carriers = {carrier["coordinate"]: carrier for carrier in found["carried_by"]}
    assert carriers["time"]["fraction"] > 0.3
    considered = {effect["id"]: effect for effect in found["considered"]}
    assert "lacks output angle" in considered["kinematic_error"]["why_not"]
    assert set(found["parameters_before"]) == set(found["parameters_after"])
    assert found["figures_before"].keys() == found["figures_after"].keys()
    page = Page((written / "report.html").read_text("utf-8"))
    assert page.faults == []
    assert "creep" in page.text


def test_an_effect_on_no_list_is_called_unknown() -> None:
    outcome = explained("on-no-list", "t03")
    assert outcome.verdict == "unexplained"
    [effect] = outcome.effects
    assert effect.id == "unknown"
    assert effect.coordinate == "branch"
    assert outcome.after.rmse_rad < 0.6 * outcome.before.rmse_rad


def test_nothing_is_added_where_nothing_is_missing() -> None:
    outcome = explained("grows-with-wear", "t01")
    assert outcome.verdict == "adequate"
    assert outcome.effects == ()
    assert outcome.before == outcome.after


def test_what_a_drive_folder_would_pass_over_is_refused() -> None:
    folder = DRIVES / "one-effect"
    with pytest.raises(UsageError, match="drive: found one beside a drive folder"):
        hdprog.explain(folder, hdprog.read_drive(folder / "drive.toml"))
    with pytest.raises(UsageError, match="rng: found a generator beside a drive folder"):
        hdprog.explain(folder, rng=np.random.default_rng(0))


def test_paths_of_files_are_refused_with_what_reads_them() -> None:
    """A drive beside a loop's path had been said to stand beside a drive folder."""
    record, settings = DRIVES / "one-effect/loops/t01.csv", DRIVES / "one-effect/drive.toml"
    loop, drive = hdprog.read_loop(record), hdprog.read_drive(settings)
    stage: Any
    for stage in (hdprog.fit, hdprog.explain):
        for path in (record, str(record)):
            with pytest.raises(UsageError, match=r"loop: found '.*t01.csv'.*hdprog\.read_loop"):
                stage(path, drive)
        with pytest.raises(UsageError, match=r"drive: found '.*'.*hdprog\.read_drive"):
            stage(loop, settings)
