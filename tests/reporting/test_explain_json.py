from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hdprog.explanation import DriveExplanation, LeftOver
from hdprog.reporting.explain_json import explain_json
from hdprog.results import DriveResult
from tests.reporting import drives, explanations

SITUATIONS = {
    "adequate": lambda: explanations.single(explanations.adequate()),
    "explained": lambda: explanations.single(explanations.record()),
    "partly_explained": lambda: explanations.single(explanations.partly()),
    "unexplained": lambda: explanations.single(explanations.unexplained()),
    "drive": explanations.of_drive,
}
CONTRACT = {
    "verdict",
    "noise_floor_rad",
    "outlier_fraction",
    "before",
    "after",
    "carried_by",
    "effects",
    "considered",
    "parameters_before",
    "parameters_after",
    "figures_before",
    "figures_after",
    "remaining_hours_before",
    "remaining_hours_after",
    "per_test",
}
ERRORS = {"rmse_rad", "heldout_rmse_rad", "reversal_rmse_rad", "lag1"}
EFFECT = {
    "id",
    "elpd_gain",
    "elpd_se",
    "parameters",
    "indistinguishable_from",
    "separating_test",
    "origin",
}


def written(result: DriveResult) -> dict[str, Any]:
    """What comes back from a file without numbers that JSON has not."""
    found = json.loads(json.dumps(explain_json(result), allow_nan=False))
    assert isinstance(found, dict)
    return found


def check(body: dict[str, Any]) -> None:
    assert set(body) >= CONTRACT
    assert set(body["before"]) == set(body["after"]) == ERRORS
    for carrier in body["carried_by"]:
        assert set(carrier) == {"coordinate", "fraction", "p_value"}
    for effect in body["effects"]:
        assert set(effect) >= EFFECT
        assert all({"q05", "q50", "q95"} <= set(q) for q in effect["parameters"].values())
    for effect in body["considered"]:
        assert {"id", "elpd_gain", "elpd_se", "why_not"} <= set(effect)
    for part in ("parameters_before", "parameters_after", "figures_before", "figures_after"):
        assert body[part]
        for levels in body[part].values():
            assert set(levels) == {"q05", "q25", "q50", "q75", "q95"}


@pytest.mark.parametrize("name", SITUATIONS)
def test_the_keys_are_those_of_the_schema(name: str) -> None:
    result: Any = SITUATIONS[name]()
    found = written(result)
    assert found["schema"] == "hdprog.explain/1"
    check(found)
    assert found["verdict"] == ("explained" if name == "drive" else name)
    for test in found["per_test"]:
        check(test)
        assert test["test_id"]
    assert bool(found["per_test"]) == (name == "drive")


def test_a_record_is_written_as_it_is() -> None:
    record = explanations.record()
    found = written(explanations.single(record))
    assert found["before"]["rmse_rad"] == record.before.rmse_rad
    assert found["parameters_after"]["K_F"]["q50"] == 78_200.0
    assert found["units"]["K_F"] == "Nm/rad"
    assert found["units"]["hysteresis_width_arcmin"] == "arcmin"
    (effect,) = found["effects"]
    assert effect["indistinguishable_from"] == ["viscous_friction", "microslip"]
    assert effect["units"]["creep.time_constant"] == "s"
    assert effect["origin"] is None
    assert found["carried_by"][0] == {"coordinate": "time", "fraction": 0.83, "p_value": 1e-5}
    assert found["remaining_hours_before"] is None
    assert found["considered"][1]["elpd_gain"] is None


def test_a_drive_is_pooled_over_its_tests() -> None:
    drive = explanations.drive_explanation()
    found = written(explanations.of_drive(drive))
    rms = math.sqrt(np.mean([test.before.rmse_rad**2 for test in drive.tests]))
    assert found["before"]["rmse_rad"] == pytest.approx(rms)
    assert found["before"]["lag1"] == pytest.approx(np.mean([t.before.lag1 for t in drive.tests]))
    assert [test["test_id"] for test in found["per_test"]] == [t.test_id for t in drive.tests]
    assert found["effects"][0]["origin"] == "wear"
    assert found["remaining_hours_before"]["q50"] == 1560.0
    assert found["remaining_hours_after"]["q95"] is None
    assert found["amplitudes"]["backlash"][0]["rms_rad"]["q50"] == 0.0
    drive.amplitudes["backlash"][0, 1:] = np.nan  # of a test that cannot show it
    hidden = written(explanations.of_drive(drive))["amplitudes"]["backlash"][0]["rms_rad"]
    assert set(hidden.values()) == {None}
    assert found["parameters_after"] == found["per_test"][-1]["parameters_after"]


def test_the_share_is_the_mean_and_the_p_values_are_joined() -> None:
    first, second = (
        explanations.record(carriers={"time": share}, test_id=name)
        for share, name in ((0.8, "t01"), (0.1, "t02"))
    )
    drive = DriveExplanation("explained", first.effects, (), {}, (first, second))
    found = written(explanations.of_drive(drive))
    (carrier,) = found["carried_by"]
    assert carrier["fraction"] == pytest.approx(0.45)
    assert carrier["p_value"] == pytest.approx(2e-5, rel=1e-3)
    weak = replace(drive, tests=(replace(second, test_id="t01"), second, second, second))
    assert written(explanations.of_drive(weak))["carried_by"][0]["p_value"] > 0.3


def test_what_is_not_a_number_is_null() -> None:
    record = explanations.record()
    broken = replace(record.before, lag1=float("nan"), reversal_rmse_rad=None)
    found = written(explanations.single(replace(record, before=broken)))
    assert found["before"]["lag1"] is None
    assert found["before"]["reversal_rmse_rad"] is None


def test_without_an_explanation_there_is_nothing_to_write() -> None:
    with pytest.raises(ValueError, match="effects were not looked for"):
        explain_json(drives.single_fit())


def test_what_was_refused_for_its_share_is_written() -> None:
    remains = LeftOver("backlash", None, 44.6)
    record = explanations.record(left_over=remains)
    found = written(explanations.single(record))
    words = found["left_over"].pop("words")
    assert "backlash would carry it best" in words
    assert found["left_over"] == {
        "id": "backlash",
        "coordinate": None,
        "log_evidence_gain": 44.6,
    }
    assert written(explanations.single(explanations.record()))["left_over"] is None
