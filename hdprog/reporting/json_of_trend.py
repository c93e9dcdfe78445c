"""The trend of a drive as the summary's JSON has it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hdprog.reporting.json_values import level_name, number, numbers, quantiles
from hdprog.reporting.trend_words import trend_warnings
from hdprog.reporting.words import keyboard_signs
from hdprog.results import (
    LEVELS,
    FleetShare,
    SteadyShare,
    SteadyWearSaid,
    SuddenEffect,
    TemperatureEffect,
    TestResult,
    TrendSummary,
    WearSaid,
)


def trend_json(trend: TrendSummary, tests: Sequence[TestResult]) -> dict[str, Any]:
    """A trend as the summary has it; the tests are those that it goes along."""
    warmth = trend.temperature
    return {
        "model": keyboard_signs(trend.model),
        "converged": trend.converged,
        "hyperparameters": {n: quantiles(v) for n, v in trend.hyperparameters.items()},
        "carried_by_prior": list(trend.carried_by_prior),
        "followed_effects": list(trend.followed),
        "sudden_effects": [_sudden(one, tests) for one in trend.sudden],
        "figures": {
            key: {
                "hours": numbers(figure.hours),
                **{
                    level_name(level): numbers(row)
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


def _sudden(found: SuddenEffect, tests: Sequence[TestResult]) -> dict[str, Any]:
    ends = [test.test_id for test in tests[found.test - 1 : found.test + 1]]
    return {"effect": found.effect, "between_tests": ends, "came": found.came}


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
        "precision": [numbers(row) for row in says.precision],
        "information": numbers(says.information),
        "steady": None if says.steady is None else _steady_said(says.steady),
    }


def _steady_said(said: SteadyWearSaid) -> dict[str, Any]:
    return {
        "log_odds": number(said.log_odds),
        "precision": [numbers(row) for row in said.precision],
        "information": numbers(said.information),
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
