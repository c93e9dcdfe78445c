"""compare.json (schema hdprog.compare/1)."""

from __future__ import annotations

from typing import Any

from hdprog.comparison.results import ComparedModel, Comparison, StiffnessBand
from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.reporting.comparison_words import verdict
from hdprog.reporting.json_values import level_name, numbers, quantiles
from hdprog.reporting.words import keyboard_signs

SCHEMA = "hdprog.compare/1"
_BAND = (0.05, 0.5, 0.95)


def comparison_json(result: Comparison) -> dict[str, Any]:
    """Content of compare.json."""
    made, said = result.provenance, verdict(result)
    return {
        "schema": SCHEMA,
        "hdprog_version": made.hdprog_version,
        "seed": made.seed,
        "quick": made.quick,
        "converged": result.converged,
        "verdict": {"label": keyboard_signs(said.label), "text": keyboard_signs(said.text)},
        "record": {
            "source": result.loop.source,
            "sha256": result.loop.sha256,
            "samples": len(result.loop),
            "two_sided": result.two_sided,
            "noise_floor_rad": result.noise_floor_rad,
        },
        "cycle": {"amplitude_Nm": result.amplitude, "width_at_Nm": result.width_torque},
        "models": [_model(rank, one) for rank, one in enumerate(result.models, start=1)],
        "left_out": [{"id": one.id, "words": one.words, "why": one.why} for one in result.left_out],
        "warnings": [keyboard_signs(text) for text in result.warnings],
        "provenance": {
            "command": made.command,
            "created": made.created,
            "versions": dict(made.versions),
            "files": dict(made.files),
            "seconds": dict(result.seconds),
        },
    }


def _model(rank: int, model: ComparedModel) -> dict[str, Any]:
    errors, evidence = model.errors, model.evidence
    arcmin = {level: ARCMIN_PER_RAD * value for level, value in model.width.items()}
    return {
        "id": model.id,
        "words": model.words,
        "source": model.source,
        "equation": model.equation,
        "where": model.where,
        "rank": rank,
        "converged": model.converged,
        "rmse_rad": errors.rmse_rad,
        "heldout_rmse_rad": errors.heldout_rmse_rad,
        "reversal_rmse_rad": errors.reversal_rmse_rad,
        "lag1": errors.lag1,
        "elpd": evidence.elpd,
        "elpd_se": evidence.se,
        "elpd_difference": evidence.difference,
        "elpd_difference_se": evidence.difference_se,
        "effective_parameters": evidence.effective_parameters,
        "doubtful_blocks": evidence.doubtful_blocks,
        "level_with_the_best": evidence.level_with_the_best,
        "stacking_weight": evidence.weight,
        "heldout_elpd_difference": evidence.heldout_difference,
        "heldout_elpd_difference_se": evidence.heldout_difference_se,
        "hysteresis_width_rad": quantiles(model.width),
        "hysteresis_width_arcmin": quantiles(arcmin),
        "local_stiffness": None if model.stiffness is None else _band(model.stiffness),
        "parameters": {
            name: {
                "unit": one.unit,
                "meaning": one.meaning,
                **quantiles(one.quantiles),
                "rhat": one.rhat,
                "ess_bulk": one.ess_bulk,
                "ess_tail": one.ess_tail,
                "contraction": one.contraction,
            }
            for name, one in model.parameters.items()
        },
        "posterior": model.method,
        "noise_model": model.noise_model,
        "sampling": dict(model.sampling),
        "seconds": model.seconds,
    }


def _band(band: StiffnessBand) -> dict[str, list[float | None]]:
    found: dict[str, list[float | None]] = {"torque_Nm": band.torque.tolist()}
    for level in _BAND:
        found[f"{level_name(level)}_Nm_per_rad"] = numbers(band.quantiles[level])
    return found
