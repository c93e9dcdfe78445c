"""What the stages hand on: frozen results of a test, of its trend and of its forecast.

They hold numbers only, ready to be written as JSON, drawn or stored.
"""

from hdprog.results.levels import DEVIATIONS_IN_90, LEVELS, by_level
from hdprog.results.of_drive import DriveResult, Provenance
from hdprog.results.of_forecast import Forecast, LoadScenario
from hdprog.results.of_test import (
    Combination,
    Diagnosis,
    EffectSummary,
    Identification,
    LoopFit,
    OtherToothAngle,
    PaperIdentification,
    ParameterDraws,
    ParameterSummary,
    ReadOff,
    Sensitivity,
    TestResult,
)
from hdprog.results.of_trend import (
    FigureTrend,
    FleetShare,
    NotReproduced,
    Shrinkage,
    SteadyShare,
    SteadyWearSaid,
    SuddenEffect,
    TemperatureEffect,
    TrendSummary,
    WearSaid,
)
from hdprog.results.since_replaced import lives, since_replaced

__all__ = [
    "DEVIATIONS_IN_90",
    "LEVELS",
    "Combination",
    "Diagnosis",
    "DriveResult",
    "EffectSummary",
    "FigureTrend",
    "FleetShare",
    "Forecast",
    "Identification",
    "LoadScenario",
    "LoopFit",
    "NotReproduced",
    "OtherToothAngle",
    "PaperIdentification",
    "ParameterDraws",
    "ParameterSummary",
    "Provenance",
    "ReadOff",
    "Sensitivity",
    "Shrinkage",
    "SteadyShare",
    "SteadyWearSaid",
    "SuddenEffect",
    "TemperatureEffect",
    "TestResult",
    "TrendSummary",
    "WearSaid",
    "by_level",
    "lives",
    "since_replaced",
]
