"""Everything about a drive, and how it came about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version

from hdprog import __version__
from hdprog.config import Drive
from hdprog.explanation import DriveExplanation, Explanation
from hdprog.results.of_forecast import Forecast, LoadScenario
from hdprog.results.of_test import TestResult
from hdprog.results.of_trend import TrendSummary


@dataclass(frozen=True)
class Provenance:
    """How a result came about."""

    hdprog_version: str
    seed: int | None  # None where a generator was handed in
    quick: bool
    command: str
    created: str  # ISO 8601, UTC
    versions: Mapping[str, str]
    files: Mapping[str, str]  # a record's name, or its path in the folder → SHA-256

    @staticmethod
    def of(
        files: Mapping[str, str],
        seed: int | None,
        quick: bool,
        packages: Sequence[str] = ("numpy", "scipy", "emcee", "arviz"),
    ) -> Provenance:
        """What is made now from records, by their names, with the versions of these packages."""
        return Provenance(
            hdprog_version=__version__,
            seed=seed,
            quick=quick,
            command="Python API",
            created=datetime.now(UTC).isoformat(timespec="seconds"),
            versions={name: version(name) for name in packages},
            files=files,
        )


@dataclass(frozen=True)
class DriveResult:
    """Everything about a drive: its tests, trend and forecasts (empty for a single fit).

    `forecasts` take the load to stay as it was, `scenarios` (where asked for) take it to change.
    `explanation` is None where effects were not looked for.
    """

    drive: Drive
    tests: tuple[TestResult, ...]
    trend: TrendSummary | None
    forecasts: tuple[Forecast, ...]
    warnings: tuple[str, ...]
    provenance: Provenance
    seconds: Mapping[str, float] = field(default_factory=dict)
    explanation: Explanation | DriveExplanation | None = None
    scenarios: tuple[LoadScenario, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether every fit and the trend converged."""
        return all(test.converged for test in self.tests) and (
            self.trend is None or self.trend.converged
        )
