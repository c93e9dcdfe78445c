from __future__ import annotations

import json
from dataclasses import replace

import pytest

from hdprog.reporting.json_values import numbers, quantiles
from hdprog.reporting.summary import summary_json
from hdprog.results import DriveResult
from tests.reporting import drives

SITUATIONS = {
    "wearing": lambda: drives.wearing(drives.LOST_MOTION, drives.SECANT),
    "healthy": drives.healthy,
    "past the limit": drives.past_limit,
    "not converged": drives.not_converged,
    "one test": lambda: drives.wearing(count=1, now=100.0, crossing=6000.0, never=0.2),
    "single fit": drives.single_fit,
}


@pytest.fixture(name="result", params=SITUATIONS)
def result_fixture(request: pytest.FixtureRequest) -> DriveResult:
    result = SITUATIONS[request.param]()
    assert isinstance(result, DriveResult)
    return result


def test_the_summary_is_json_and_has_what_the_schema_names(result: DriveResult) -> None:
    summary = json.loads(json.dumps(summary_json(result), allow_nan=False))
    assert summary["schema"] == "hdprog.summary/1"
    assert {"hdprog_version", "seed", "drive", "tests", "trend", "forecast", "warnings"} <= set(
        summary
    )
    assert summary["drive"]["id"] == "cell3-axis2"
    for test in summary["tests"]:
        assert set(test["parameters"]) == {"K_F", "K_W", "a", "b", "T_T", "c", "T_i", "mu"}
        assert {"mean", "sd", "q05", "q25", "q50", "q75", "q95"} <= set(test["parameters"]["K_F"])
        assert {"rhat", "ess_bulk", "ess_tail", "contraction"} <= set(test["parameters"]["K_F"])
        assert {"q05", "q50", "q95"} <= set(test["figures"]["hysteresis_width_arcmin"])
        assert {"test_id", "service_hours", "converged", "effects"} <= set(test)
        assert {"rmse_rad", "noise_floor_rad", "warnings"} <= set(test)
    assert len(summary["forecast"]) == len(result.forecasts)
    for entry in summary["forecast"]:
        assert {"q05", "q25", "q50", "q75", "q95"} == set(entry["remaining_hours"])
        assert all(len(pair) == 2 for pair in entry["crossing_probability"])
    assert summary["verdict"]["text"]


def test_forecasts_come_in_the_order_of_the_limits_and_the_first_of_all_last() -> None:
    summary = summary_json(drives.wearing(drives.LOST_MOTION, drives.SECANT))
    found = [
        tuple(entry[key] for key in ("quantity", "limit", "direction", "at_torque_Nm"))
        for entry in summary["forecast"]
    ]
    assert found == [
        ("lost_motion_arcmin", 2.0, "above", None),
        ("secant_stiffness_Nm_per_rad", 12000.0, "below", 14.0),
        ("first_limit", None, None, None),
    ]


def test_a_single_fit_has_no_forecast_and_no_trend() -> None:
    summary = summary_json(drives.single_fit())
    assert summary["forecast"] == []
    assert summary["trend"] is None


def test_what_is_not_a_number_is_null() -> None:
    result = drives.single_fit()
    test = result.tests[0]
    broken = replace(test.parameters["a"], rhat=float("nan"), mean=float("inf"))
    doubtful = replace(test, parameters={**test.parameters, "a": broken})
    summary = summary_json(replace(result, tests=(doubtful,)))
    assert summary["tests"][0]["parameters"]["a"]["rhat"] is None
    assert summary["tests"][0]["parameters"]["a"]["mean"] is None


def test_a_quantile_past_the_horizon_is_null() -> None:
    summary = summary_json(drives.wearing(crossing=15_000.0, never=0.2))
    assert summary["forecast"][0]["remaining_hours"]["q95"] is None
    assert summary["forecast"][0]["remaining_hours"]["q05"] is not None


def test_units_come_with_the_numbers() -> None:
    units = summary_json(drives.wearing())["units"]
    assert units["lost_motion_arcmin"] == "arcmin"
    assert units["secant_stiffness_Nm_per_rad@14Nm"] == "Nm/rad"
    assert units["K_F"] == "Nm/rad"


def test_a_zero_in_json_has_no_sign() -> None:
    assert repr(numbers([-0.0, -1.0, float("nan")])) == "[0.0, -1.0, None]"
    assert repr(quantiles({0.05: -0.0})) == "{'q05': 0.0}"


def test_what_did_not_converge_comes_first_among_the_warnings() -> None:
    summary = summary_json(drives.not_converged())
    assert summary["warnings"][0] == summary["verdict"]["sentences"][0]
    assert summary["warnings"][0].startswith("Not converged: ")
    assert not any("onverged" in text for text in summary_json(drives.healthy())["warnings"])
