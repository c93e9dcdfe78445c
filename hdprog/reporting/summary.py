"""The summary of a drive as JSON, schema `hdprog.summary/1`."""

from __future__ import annotations

import math
from typing import Any

from hdprog.physics.parameters import BY_NAME
from hdprog.reporting.declared_words import declared_words
from hdprog.reporting.drive_name import drive_name
from hdprog.reporting.fit_names import explanations
from hdprog.reporting.json_of_test import test_json
from hdprog.reporting.json_of_trend import trend_json
from hdprog.reporting.json_values import number, numbers, quantiles
from hdprog.reporting.outlook import dated, next_test_hours
from hdprog.reporting.reader_units import shown_in
from hdprog.reporting.verdict import verdict
from hdprog.reporting.words import FIRST_LIMIT, keyboard_signs, quantity
from hdprog.results import DriveResult, Forecast, Provenance

SCHEMA = "hdprog.summary/1"


def summary_json(result: DriveResult) -> dict[str, Any]:
    """Summary of a drive, ready for `json.dumps(..., allow_nan=False)`.

    What is not a finite number is null, a quantile past the horizon among it; `forecast` is
    empty for a single fit.
    """
    said, by_test = verdict(result), explanations(result)
    with shown_in(result.drive.report):  # words have the reader's units, numbers their own
        trend = None if result.trend is None else trend_json(result.trend, result.tests)
        tests = [test_json(test, by_test.get(test.test_id)) for test in result.tests]
        declared = [keyboard_signs(text) for text in declared_words(result)]
    sentences = [keyboard_signs(sentence) for sentence in said.sentences]
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
            "sentences": sentences,
        },
        "next_test_hours": number(next_test_hours(result)),
        "dated": dated(result),
        "tests": tests,
        "trend": trend,
        "forecast": [_forecast(forecast) for forecast in result.forecasts],
        "load_scenarios": [
            {"load": number(one.load), "forecast": [_forecast(each) for each in one.forecasts]}
            for one in result.scenarios
        ],
        # Whoever reads the warnings alone is told first what did not converge, as the verdict does.
        "warnings": [*(sentences[:1] if said.provisional else []), *result.warnings, *declared],
        "units": _units(result),
        "report": {
            "angle_unit": result.drive.report.angle_unit,
            "torque_unit": result.drive.report.torque_unit,
        },
        "provenance": _provenance(result.provenance),
    }


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
        "probability_held_up_by_end_of_wear": number(forecast.probability_held_up_by_end_of_wear),
        "remaining_hours": quantiles(forecast.remaining_hours),
        "crossing_probability": [numbers(pair) for pair in forecast.crossing_probability],
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
