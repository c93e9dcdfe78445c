"""backtest.json (schema hdprog.backtest/1)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hdprog.forecast.backtest import INTERVALS, CrossingScore, FigureScore, OriginScores
from hdprog.forecast.backtest_pool import (
    FEW,
    BacktestResult,
    Coverage,
    DriveScores,
    bins_for,
    crossing_courses,
    crossing_coverage,
    distinct_crossings,
    figure_coverage,
    figure_skills,
    lateness,
)
from hdprog.forecast.scores import transform_histogram
from hdprog.reporting.backtest_words import crossings, figures, verdict
from hdprog.reporting.json_values import number, quantiles
from hdprog.reporting.words import keyboard_signs

SCHEMA = "hdprog.backtest/1"


def backtest_json(result: BacktestResult) -> dict[str, Any]:
    """Content of backtest.json."""
    made, said = result.provenance, verdict(result)
    return {
        "schema": SCHEMA,
        "hdprog_version": made.hdprog_version,
        "seed": made.seed,
        "quick": made.quick,
        "converged": result.converged,
        "verdict": {"label": keyboard_signs(said.label), "text": keyboard_signs(said.text)},
        "fitted_with": "drive model alone",
        "pooled": _pooled(result.drives),
        "drives": [_drive(drive) for drive in result.drives],
        "left_out": [{"folder": name, "reason": reason} for name, reason in result.left_out],
        "provenance": {
            "command": made.command,
            "created": made.created,
            "versions": dict(made.versions),
            "files": dict(made.files),
        },
    }


def _pooled(drives: Sequence[DriveScores]) -> dict[str, Any]:
    scores = crossings(drives)
    count = distinct_crossings(drives)
    return {
        "crossings": {
            "forecasts": len(scores),
            "distinct": count,
            "enough_for_a_verdict": count >= FEW,
            "crossing_seen": sum(score.crossing_seen for score in scores),
            "coverage": [_coverage(crossing_coverage(scores, level)) for level in INTERVALS],
            "mean_crps_hours": _mean([score.crps_hours for score in scores]),
            "mean_log_score": _mean([score.log_score for score in scores]),
            **_lateness(drives),
            "pit_histogram": _histogram([score.transform for score in scores]),
        },
        "next_tests": _figures(figures(drives, ahead=1)),
        "later_tests": _figures(figures(drives)),
    }


def _lateness(drives: Sequence[DriveScores]) -> dict[str, Any]:
    late = lateness(drives)
    beyond = late is not None and math.isinf(late)
    return {"late_share": None if beyond else late, "late_past_horizon": beyond}


def _figures(scores: Sequence[FigureScore]) -> dict[str, Any]:
    return {
        "predictions": len(scores),
        "coverage": [_coverage(figure_coverage(scores, level)) for level in INTERVALS],
        "pit_histogram": _histogram([score.transform for score in scores]),
        "figures": [
            {
                "figure": skill.key,
                "predictions": skill.count,
                "mean_crps": skill.crps,
                "mean_line_error": skill.line_error,
                "ratio": skill.ratio,
            }
            for skill in figure_skills(scores)
        ],
    }


def _coverage(found: Coverage | None) -> dict[str, Any] | None:
    if found is None:
        return None
    low, high = found.range
    return {
        "nominal": found.nominal,
        "held": found.held,
        "forecasts": found.count,
        "expected_share": found.expected,
        "range_95": [low, high],
        "kupiec_p_value": found.p_value,
    }


def _histogram(transforms: Sequence[float]) -> dict[str, Any] | None:
    if not transforms:
        return None
    found = transform_histogram(transforms, bins_for(len(transforms)))
    return {
        "counts": found.counts.tolist(),
        "band_95_simultaneous": [found.low, found.high],
    }


def _drive(drive: DriveScores) -> dict[str, Any]:
    return {
        "id": drive.drive_id,
        "folder": drive.name,
        "tests": drive.tests,
        "horizon_hours": drive.horizon_hours,
        "converged": drive.converged,
        "tests_not_converged": list(drive.unfitted),
        "warnings": list(drive.warnings),
        **_lateness([drive]),
        "crossings": [
            {
                "figure": course.key,
                "crossed_at_hours": course.crossed_at,
                "prognostic_horizon_hours": course.prognostic_horizon,
                "cumulative_relative_accuracy": course.accuracy,
            }
            for course in crossing_courses([drive])
        ],
        "origins": [_origin(origin) for origin in drive.origins],
    }


def _origin(origin: OriginScores) -> dict[str, Any]:
    return {
        "test_id": origin.test_id,
        "service_hours": origin.service_hours,
        "tests_known": origin.known,
        "converged": origin.converged,
        "limits_passed": list(origin.passed),
        "forecasts": [_crossing(score) for score in origin.crossings],
        "later_tests": [_figure(score) for score in origin.figures],
    }


def _crossing(score: CrossingScore) -> dict[str, Any]:
    limit = score.limit
    return {
        "quantity": limit.quantity,
        "limit": limit.threshold,
        "direction": limit.direction,
        "at_torque_Nm": limit.at_torque_Nm,
        "forecast_hours": quantiles(score.quantiles),
        "crossed_at_hours": number(score.crossed_at),
        "seen_until_hours": score.seen_until,
        "from_truth": score.from_truth,
        "passed_between_hours": None if score.passed_between is None else [*score.passed_between],
        **_intervals(score.held),
        "own_probability_50": score.own_probability[0.5],
        "own_probability_90": score.own_probability[0.9],
        "probability_crossed_by_then": score.crossed_by_then,
        "crps_hours": score.crps_hours,
        "log_score": score.log_score,
        "pit": score.transform,
        "late_hours": score.late_hours,
        "probability_within_alpha": score.within_alpha,
        "relative_accuracy": score.accuracy,
    }


def _figure(score: FigureScore) -> dict[str, Any]:
    return {
        "test_id": score.test_id,
        "service_hours": score.service_hours,
        "tests_ahead": score.ahead,
        "figure": score.key,
        "measured": score.measured,
        "predicted": quantiles(score.quantiles),
        **_intervals(score.held),
        "crps": score.crps,
        "line_error": score.line_error,
        "pit": score.transform,
    }


def _intervals(held: Mapping[float, bool]) -> dict[str, bool]:
    return {"held_50": held[0.5], "held_90": held[0.9]}


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None
