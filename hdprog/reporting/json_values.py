"""Numbers and quantiles as JSON has them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any


def number(value: float | None) -> float | None:
    """A finite number as JSON has it, a zero without a sign; else null."""
    if value is None or not math.isfinite(value):
        return None
    return float(value) + 0.0  # −0 + 0 is 0


def numbers(values: Iterable[float]) -> list[float | None]:
    """Finite numbers as JSON has them, null for others."""
    return [number(float(value)) for value in values]


def level_name(level: float) -> str:
    """Name of a quantile level: "q05" for 0.05."""
    return f"q{round(100 * level):02d}"


def quantiles(levels: Mapping[float, Any]) -> dict[str, float | None]:
    """Values by level under the names of the contract, q05 and so on."""
    return {level_name(level): number(value) for level, value in sorted(levels.items())}
