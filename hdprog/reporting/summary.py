"""The summary of a drive as JSON, schema `hdprog.summary/1`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hdprog.physics.parameters import BY_NAME
from hdprog.reporting.drive_name import drive_name
from hdprog.reporting.outlook import next_test_hours
from hdprog.reporting.sections.paper_method import where_it_fails
from hdprog.reporting.trend_words import trend_warnings
from hdprog.reporting.verdict import verdict
from hdprog.reporting.weak_words import weak_words
from hdprog.reporting.words import FIRST_LIMIT, keyboard_signs, quantity
from hdprog.results import (
    LEVELS,
    Combination,
    DriveResult,
    FleetShare,
    Forecast,
    Identification,
    OtherToothAngle,
    ParameterSummary,
    Provenance,
    Sensitivity,
    SteadyShare,
    SteadyWearSaid,
    TemperatureEffect,
    TestResult,
    TrendSummary,
    WearSaid,
)

SCHEMA = "hdprog.summary/1"


def summary_json(result: DriveResult) -> dict[str, Any]:
    """Summary of a drive, ready for `json.dumps(..., allow_nan=False)`.

    What is not a finite number is null, a quantile past the horizon among it; `forecast` is
    empty for a single fit.
    """
    said = verdict(result)
    return {
        "schema": SCHEMA,
        "hdprog_version": result.provenance.hdprog_version,
        "seed": result.provenance.seed,
        "drive": _drive(result),
        "converged": result.converged,
        "verdict": {
            "status": said.status,
            "provisional": said.provisional,
            "label": said.label,
            "text": keyboard_signs(said.text),
        },
        "next_test_hours": number(next_test_hours(result)),
        "tests": [_test(test) for test in result.tests],
        "trend": None if result.trend is None else _trend(result.trend, result.tests),
        "forecast": [_forecast(forecast) for forecast in result.forecasts],
        "load_scenarios": [
            {"load": number(one.load), "forecast": [_forecast(each) for each in one.forecasts]}
            for one in result.scenarios
        ],
        "warnings": list(result.warnings),
        "units": _units(result),
        "report": {
            "angle_unit": result.drive.report.angle_unit,
            "torque_unit": result.drive.report.torque_unit,
        },
        "provenance": _provenance(result.provenance),
    }


def number(value: float | None) -> float | None:
    """A finite number as JSON has it, else null."""
    if value is None or not math.isfinite(value):
        return None
    return float(value)


def _numbers(values: Iterable[float]) -> list[float | None]:
    return [number(float(value)) for value in values]


def level_name(level: float) -> str:
    """Name of a quantile level: "q05" for 0.05."""
    return f"q{round(100 * level):02d}"


def quantiles(levels: Mapping[float, Any]) -> dict[str, float | None]:
    """Values by level under the names of the contract, q05 and so on."""
    return {level_name(level): number(value) for level, value in sorted(levels.items())}


def _drive(result: DriveResult) -> dict[str, Any]:
    drive = result.drive
    return {
        "id": drive_name(result),
        "model": drive.model,
        "ratio": number(drive.ratio),
        "alpha_deg": number(round(math.degrees(drive.alpha), 9)),
        "rated_torque_Nm": number(drive.rated_torque),
        "reference_torque_Nm": number(drive.reference_torque),
    }


def _parameter(summary: ParameterSummary) -> dict[str, float | None]:
    return {
        "mean": number(summary.mean),
        "sd": number(summary.sd),
        **quantiles(summary.quantiles),
        "rhat": number(summary.rhat),
        "ess_bulk": number(summary.ess_bulk),
        "ess_tail": number(summary.ess_tail),
        "contraction": number(summary.contraction),
    }


def _test(test: TestResult) -> dict[str, Any]:
    return {
        "test_id": test.test_id,
        "service_hours": number(test.service_hours),
        "date": test.date,
        "note": test.note,
        "event": test.event,
        "converged": test.converged,
        "parameters": {name: _parameter(value) for name, value in test.parameters.items()},
        "figures": {key: quantiles(levels) for key, levels in test.figures.items()},
        "figures_with_effects": {
            key: quantiles(levels) for key, levels in test.figures_with_effects.items()
        },
        "effects": list(test.effects),
        "rmse_rad": number(test.rmse_rad),
        "noise_floor_rad": number(test.noise_floor_rad),
        "outlier_fraction": number(test.outlier_fraction),
        "residual_correlation": number(test.residual_correlation),
        "noise_model": test.noise_model,
        "prior": test.prior_name,
        "samples": len(test.loop),
        "diagnostics": {name: number(value) for name, value in test.diagnostics.items()},
        "identification": _identification(test.identification),
        "sensitivity": {name: _sensitivity(found) for name, found in test.sensitivity.items()},
        "other_tooth_angle": _other_tooth_angle(test.other_tooth_angle),
        "paper_identification": _paper(test),
        "warnings": [*test.warnings, *weak_words(test)],
    }


def _identification(state: Identification | None) -> dict[str, Any] | None:
    if state is None:
        return None
    return {
        "largest_torque_Nm": number(state.largest_torque),
        "probability_T_i_beyond_record": number(state.beyond_record),
        "one_spring": state.one_spring,
        "combined_stiffness_Nm_per_rad": _combination(state.combined_stiffness),
        "no_load_friction_Nm": _combination(state.no_load_friction),
    }


def _combination(found: Combination) -> dict[str, float | None]:
    return {**quantiles(found.quantiles), "contraction": number(found.contraction)}


def _sensitivity(found: Sensitivity) -> dict[str, Any]:
    return {
        "prior": number(found.prior),
        "record": number(found.record),
        "rests_on": found.diagnosis,
        "shift_from_prior": number(found.shift),
    }


def _other_tooth_angle(other: OtherToothAngle | None) -> dict[str, Any] | None:
    if other is None:
        return None
    return {
        "alpha_deg": number(round(math.degrees(other.alpha), 9)),
        "parameters": {name: quantiles(levels) for name, levels in other.parameters.items()},
        "figures": {key: quantiles(levels) for key, levels in other.figures.items()},
    }


def _paper(test: TestResult) -> dict[str, Any] | None:
    found = test.paper
    if found is None:
        return None
    return {
        "points": {
            name: {"torque_Nm": number(torque), "angle_rad": number(angle)}
            for name, (torque, angle) in found.points.items()
        },
        "parameters": {name: number(value) for name, value in found.parameters.items()},
        "other_choices_of_points": {
            name: {"least": number(low), "largest": number(high)}
            for name, (low, high) in found.other_choices.items()
        },
        "choices_tried": found.choices_tried,
        "choices_solved": found.choices_solved,
        "figures": {key: number(value) for key, value in found.figures.items()},
        "rmse_rad": number(found.rmse_rad),
        "where_it_fails": [keyboard_signs(text) for text in where_it_fails(test)],
    }


def _trend(trend: TrendSummary, tests: Sequence[TestResult]) -> dict[str, Any]:
    warmth = trend.temperature
    return {
        "model": keyboard_signs(trend.model),
        "converged": trend.converged,
        "hyperparameters": {n: quantiles(v) for n, v in trend.hyperparameters.items()},
        "carried_by_prior": list(trend.carried_by_prior),
        "followed_effects": list(trend.followed),
        "figures": {
            key: {
                "hours": _numbers(figure.hours),
                **{
                    level_name(level): _numbers(row)
                    for level, row in zip(LEVELS, figure.quantiles, strict=True)
                },
            }
            for key, figure in trend.figures.items()
        },
        "diagnostics": {name: number(value) for name, value in trend.diagnostics.items()},
        "says": None if trend.says is None else _says(trend.says),
        "fleet": None if trend.fleet is None else _fleet(trend.fleet),
        **({} if warmth is None else {"temperature": _temperature(warmth)}),
        "warnings": [keyboard_signs(text) for text in trend_warnings(trend, tests)],
    }


def _temperature(found: TemperatureEffect) -> dict[str, Any]:
    return {
        "reference_C": number(found.reference_C),
        "spread_K": number(found.spread_K),
        "tests_without": found.unknown,
        "percent_per_10K": {n: quantiles(v) for n, v in found.percent_per_10K.items()},
    }


def _says(says: WearSaid) -> dict[str, Any]:
    return {
        "wear_prior": says.wear_prior,
        "deviates": list(says.deviates),
        "precision": [_numbers(row) for row in says.precision],
        "information": _numbers(says.information),
        "steady": None if says.steady is None else _steady_said(says.steady),
    }


def _steady_said(said: SteadyWearSaid) -> dict[str, Any]:
    return {
        "log_odds": number(said.log_odds),
        "precision": [_numbers(row) for row in said.precision],
        "information": _numbers(said.information),
    }


def _steady_share(found: SteadyShare) -> dict[str, Any]:
    return {
        "told_by": found.told,
        "chance_by_fleet": number(found.fleet),
        "chance": number(found.own),
    }


def _fleet(fleet: FleetShare) -> dict[str, Any]:
    return {
        "drives": list(fleet.drives),
        "hyperparameters": {
            name: {
                "any_drive": quantiles(one.shipped),
                "fleet": quantiles(one.fleet),
                "without_fleet": quantiles(one.own),
            }
            for name, one in fleet.hyperparameters.items()
        },
        "left_out": list(fleet.left_out),
        "steady_pace": None if fleet.steady is None else _steady_share(fleet.steady),
    }


def _forecast(forecast: Forecast) -> dict[str, Any]:
    limit = forecast.limit
    return {
        "quantity": FIRST_LIMIT if limit is None else limit.quantity,
        "limit": None if limit is None else number(limit.threshold),
        "direction": None if limit is None else limit.direction,
        "at_torque_Nm": None if limit is None else number(limit.at_torque_Nm),
        "now_hours": number(forecast.now_hours),
        "already_crossed": forecast.already_crossed,
        "acceptable_risk": number(forecast.acceptable_risk),
        "horizon_hours": number(forecast.horizon_hours),
        "inspect_before_hours": number(forecast.inspect_before_hours),
        "probability_crossed_by_shutdown": number(forecast.probability_crossed_by_shutdown),
        "probability_crossed_by_horizon": number(forecast.probability_crossed_by_horizon),
        "remaining_hours": quantiles(forecast.remaining_hours),
        "crossing_probability": [_numbers(pair) for pair in forecast.crossing_probability],
    }


def _units(result: DriveResult) -> dict[str, str]:
    """Name the unit of every figure and parameter that the summary holds."""
    units: dict[str, str] = {}
    for test in result.tests:
        units |= {name: BY_NAME[name].unit for name in test.parameters if name in BY_NAME}
        units |= {key: quantity(key).unit for key in test.figures if quantity(key).unit}
    return units


def _provenance(provenance: Provenance) -> dict[str, Any]:
    return {
        "command": provenance.command,
        "quick": provenance.quick,
        "created": provenance.created,
        "versions": dict(provenance.versions),
        "files_sha256": dict(provenance.files),
    }
