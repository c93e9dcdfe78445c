"""What closing the loop found, as JSON, schema `hdprog.explain/1`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from hdprog.explanation import (
    Carrier,
    ConsideredEffect,
    DriveExplanation,
    ErrorFigures,
    Explanation,
    FoundEffect,
    LeftOver,
    Quantiles,
)
from hdprog.physics.parameters import BY_NAME, FloatArray
from hdprog.reporting.drive_name import drive_name
from hdprog.reporting.effect_words import left_over_words
from hdprog.reporting.json_values import number, quantiles
from hdprog.reporting.pooled import pooled_carriers, pooled_errors, root_mean_square
from hdprog.reporting.words import quantity
from hdprog.results import DriveResult

SCHEMA = "hdprog.explain/1"


def explain_json(result: DriveResult) -> dict[str, Any]:
    """Explanation of a record or of a drive, ready for `json.dumps(..., allow_nan=False)`.

    Of a drive the top level is pooled over its tests: errors, noise floor and repeatability are
    the root mean square over the tests, correlation and share of outliers their mean; in
    `carried_by` the fraction is the mean and the p-value that of all tests joined; parameters and
    figures before and after are those of the last test; an amplitude is null where a test cannot
    show the effect. `per_test` holds one object a test, empty for a single record; what is left
    over was judged by all tests, and its gain there is that of all. What is not a finite number is
    null.

    Raises
    ------
    ValueError
        The result has no explanation: effects were not looked for.
    """
    found = result.explanation
    if found is None:
        raise ValueError("effects were not looked for: there is no explanation to write")
    body = _drive(found) if isinstance(found, DriveExplanation) else _record(found)
    return {
        "schema": SCHEMA,
        "hdprog_version": result.provenance.hdprog_version,
        "seed": result.provenance.seed,
        "drive": {"id": drive_name(result)},
        **body,
        "units": _units(body),
    }


def _record(found: Explanation) -> dict[str, Any]:
    return {
        "test_id": found.test_id,
        "service_hours": number(found.service_hours),
        "converged": found.converged,
        "verdict": found.verdict,
        "noise_floor_rad": number(found.noise_floor_rad),
        "repeatability_rad": number(found.repeatability_rad),
        "outlier_fraction": number(found.outlier_fraction),
        "before": _errors(found.before),
        "after": _errors(found.after),
        "branch_rmse_rad": {
            name: {"before": number(before), "after": number(after)}
            for name, (before, after) in found.branch_rmse.items()
        },
        "carried_by": [_carrier(carrier) for carrier in found.carried_by],
        "effects": [_effect(effect) for effect in found.effects],
        "considered": [_considered(effect) for effect in found.considered],
        "left_over": _left_over(found.left_over),
        "strained": {name: number(value) for name, value in found.strained.items()},
        **_before_after(found),
        "remaining_hours_before": None,
        "remaining_hours_after": None,
        "warnings": list(found.warnings),
        "per_test": [],
    }


def _drive(found: DriveExplanation) -> dict[str, Any]:
    tests = found.tests
    return {
        "converged": all(test.converged for test in tests),
        "verdict": found.verdict,
        "noise_floor_rad": number(root_mean_square(t.noise_floor_rad for t in tests)),
        "repeatability_rad": number(root_mean_square(t.repeatability_rad for t in tests)),
        "outlier_fraction": number(math.fsum(t.outlier_fraction for t in tests) / len(tests)),
        "before": _errors(pooled_errors(tests, lambda test: test.before)),
        "after": _errors(pooled_errors(tests, lambda test: test.after)),
        "carried_by": [_carrier(carrier) for carrier in pooled_carriers(tests)],
        "effects": [_effect(effect) for effect in found.effects],
        "considered": [_considered(effect) for effect in found.considered],
        "left_over": _left_over(found.left_over),
        **_before_after(tests[-1]),
        "amplitudes": {
            name: [_amplitude(row) for row in table] for name, table in found.amplitudes.items()
        },
        "remaining_hours_before": _hours(found.remaining_hours_before),
        "remaining_hours_after": _hours(found.remaining_hours_after),
        "per_test": [_record(test) for test in tests],
    }


def _by_name(values: Mapping[str, Quantiles]) -> dict[str, dict[str, float | None]]:
    return {name: quantiles(levels) for name, levels in values.items()}


def _left_over(found: LeftOver | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {
        "id": found.id,
        "coordinate": found.coordinate,
        "log_evidence_gain": number(found.log_evidence_gain),
        "words": left_over_words(found),
    }


def _hours(levels: Mapping[float, float | None] | None) -> dict[str, float | None] | None:
    return None if levels is None else quantiles(levels)


def _amplitude(row: FloatArray) -> dict[str, Any]:
    hours, low, middle, high = map(float, row)
    return {
        "service_hours": number(hours),
        "rms_rad": {"q05": number(low), "q50": number(middle), "q95": number(high)},
    }


def _errors(errors: ErrorFigures) -> dict[str, float | None]:
    return {
        "rmse_rad": number(errors.rmse_rad),
        "heldout_rmse_rad": number(errors.heldout_rmse_rad),
        "reversal_rmse_rad": number(errors.reversal_rmse_rad),
        "lag1": number(errors.lag1),
    }


def _carrier(carrier: Carrier) -> dict[str, Any]:
    return {
        "coordinate": carrier.coordinate,
        "fraction": number(carrier.fraction),
        "p_value": number(carrier.p_value),
    }


def _effect(effect: FoundEffect) -> dict[str, Any]:
    return {
        "id": effect.id,
        "words": effect.words,
        "coordinate": effect.coordinate,
        "log_evidence_gain": number(effect.log_evidence_gain),
        "elpd_gain": number(effect.elpd_gain),
        "elpd_se": number(effect.elpd_se),
        "share": number(effect.share),
        "parameters": _by_name(effect.parameters),
        "units": dict(effect.units),
        "indistinguishable_from": list(effect.indistinguishable_from),
        "separating_test": effect.separating_test,
        "advice": effect.advice,
        "origin": effect.origin,
    }


def _considered(effect: ConsideredEffect) -> dict[str, Any]:
    return {
        "id": effect.id,
        "words": effect.words,
        "log_evidence_gain": number(effect.log_evidence_gain),
        "elpd_gain": number(effect.elpd_gain),
        "elpd_se": number(effect.elpd_se),
        "why_not": effect.why_not,
    }


def _before_after(found: Explanation) -> dict[str, Any]:
    return {
        "parameters_before": _by_name(found.parameters_before),
        "parameters_after": _by_name(found.parameters_after),
        "figures_before": _by_name(found.figures_before),
        "figures_after": _by_name(found.figures_after),
    }


def _units(body: Mapping[str, Any]) -> dict[str, str]:
    """Name the unit of every base parameter and figure in the body; effects carry their own."""
    units: dict[str, str] = {}
    for part in (body, *body["per_test"]):
        for when in ("before", "after"):
            named = part[f"parameters_{when}"]
            units |= {name: BY_NAME[name].unit for name in named if name in BY_NAME}
            keys = part[f"figures_{when}"]
            units |= {key: quantity(key).unit for key in keys if quantity(key).unit}
    return units
