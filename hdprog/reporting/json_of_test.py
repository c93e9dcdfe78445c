"""One test of a drive, or one loop, as the summary's JSON has it."""

from __future__ import annotations

import math
from typing import Any

from hdprog.explanation import Explanation
from hdprog.reporting.json_values import number, quantiles
from hdprog.reporting.left_structure import structure_warnings
from hdprog.reporting.read_off_words import missed_words
from hdprog.reporting.sections.paper_method import where_it_fails
from hdprog.reporting.weak_words import weak_words
from hdprog.reporting.words import keyboard_signs
from hdprog.results import (
    Combination,
    EffectSummary,
    Identification,
    OtherToothAngle,
    ParameterSummary,
    ReadOff,
    Sensitivity,
    TestResult,
)


def test_json(test: TestResult, explanation: Explanation | None) -> dict[str, Any]:
    """A test as the summary has it, with what a search explained of it, if there was one."""
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
        "read_off": {key: _read_off(found) for key, found in test.read_off.items()},
        "effects": list(test.effects),
        "effect_parameters": {one.id: _effect(one) for one in test.effect_summaries},
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
        "warnings": [
            *missed_words(test),
            *test.warnings,
            *structure_warnings(test, explanation),
            *weak_words(test),
        ],
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


def _read_off(found: ReadOff) -> dict[str, Any]:
    return {
        "record": number(found.record),
        "record_sd": number(found.record_sd),
        "fit": quantiles(found.fit),
        "differs": found.differs,
    }


def _effect(found: EffectSummary) -> dict[str, Any]:
    return {
        name: {"unit": found.units[name], **quantiles(levels)}
        for name, levels in found.parameters.items()
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
