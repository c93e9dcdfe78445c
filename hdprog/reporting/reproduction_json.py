"""reproduction.json (schema hdprog.reproduce-paper/1)."""

from __future__ import annotations

from typing import Any

from hdprog.reporting.json_values import quantiles
from hdprog.reporting.reproduction_words import verdict
from hdprog.reporting.words import keyboard_signs
from hdprog.reproduction.results import BranchPair, Curve, Recovery, Reproduction

SCHEMA = "hdprog.reproduce-paper/1"


def reproduction_json(result: Reproduction) -> dict[str, Any]:
    """Content of reproduction.json."""
    made = result.provenance
    return {
        "schema": SCHEMA,
        "hdprog_version": made.hdprog_version,
        "seed": made.seed,
        "quick": made.quick,
        "converged": result.converged,
        "verdict": keyboard_signs(verdict(result).text),
        "findings": [
            {
                "figure": one.figure,
                "claim": one.claim,
                "came_out": keyboard_signs(one.came_out),
                "outcome": one.outcome,
                "numbers": dict(one.numbers),
            }
            for one in result.findings
        ],
        "fig10_loops": [_loop(one) for one in result.loops],
        "fig11_loops": [_loop(one) for one in result.others],
        "sensitivities": [
            {
                "parameter": sweep.parameter,
                "figure": sweep.figure,
                "values": list(sweep.values),
                "loops": [_loop(one) for one in sweep.loops],
            }
            for sweep in result.sweeps
        ],
        "fig14_stiffness_curves": [_curve(one, "angle_rad") for one in result.stiffness],
        "fig15_local_stiffness": [_curve(one, "stiffness_Nm_per_rad") for one in result.local],
        "tooth_mesh": [_curve(one, "angle_rad") for one in result.mesh],
        "recoveries": [_recovery(one) for one in result.recoveries],
        "warnings": list(result.warnings),
        "provenance": {
            "command": made.command,
            "created": made.created,
            "versions": dict(made.versions),
            "seconds": dict(result.seconds),
        },
    }


def _loop(loop: BranchPair) -> dict[str, Any]:
    return {
        "label": loop.label,
        "torque_Nm": _numbers(loop.torque.tolist()),
        "loading_rad": _numbers(loop.rising.tolist()),
        "unloading_rad": _numbers(loop.falling.tolist()),
    }


def _curve(curve: Curve, name: str) -> dict[str, Any]:
    return {
        "label": curve.label,
        "torque_Nm": _numbers(curve.x.tolist()),
        name: _numbers(curve.y.tolist()),
    }


def _numbers(values: list[float]) -> list[float]:
    """Curves to seven digits, which is more than any of them means."""
    return [float(f"{value:.7g}") for value in values]


def _recovery(one: Recovery) -> dict[str, Any]:
    return {
        "record": one.label,
        "converged": one.converged,
        "numbers": {
            name: {
                "truth": one.truth[name],
                **quantiles(levels),
                "deviations": one.deviations[name],
            }
            for name, levels in one.found.items()
        },
    }
