"""A drive's tests taken together: errors and carriers of the residual pooled over them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from hdprog.explanation import Carrier, ErrorFigures, Explanation


def root_mean_square(values: Iterable[float | None]) -> float | None:
    """Root mean square of what is there; None where nothing is."""
    found = [value for value in values if value is not None]
    if not found:
        return None
    return math.sqrt(sum(value * value for value in found) / len(found))


def tests_with(identifier: str, tests: Sequence[Explanation]) -> list[Explanation]:
    """The tests that carry an effect, in order."""
    return [test for test in tests if any(effect.id == identifier for effect in test.effects)]


def pooled_errors(
    tests: Sequence[Explanation], which: Callable[[Explanation], ErrorFigures]
) -> ErrorFigures:
    """Root mean square over the tests of each error; the correlation is their mean.

    Tests count alike, whatever their length. Errors at reversals are those of the tests that have
    reversals.
    """
    errors = [which(test) for test in tests]
    return ErrorFigures(
        rmse_rad=root_mean_square(e.rmse_rad for e in errors) or 0.0,
        heldout_rmse_rad=root_mean_square(e.heldout_rmse_rad for e in errors) or 0.0,
        reversal_rmse_rad=root_mean_square(e.reversal_rmse_rad for e in errors),
        lag1=float(np.mean([e.lag1 for e in errors])),
    )


def pooled_carriers(tests: Sequence[Explanation]) -> tuple[Carrier, ...]:
    """Carriers of the residual, largest share first.

    The share of a coordinate is its mean over the tests that have the coordinate; its p-value is
    the smallest of theirs times their number, at most 1 (Bonferroni).
    """
    by_name: dict[str, list[Carrier]] = {}
    for test in tests:
        for carrier in test.carried_by:
            by_name.setdefault(carrier.coordinate, []).append(carrier)
    pooled = [
        Carrier(
            name,
            float(np.mean([carrier.fraction for carrier in found])),
            min(1.0, len(found) * min(carrier.p_value for carrier in found)),
        )
        for name, found in by_name.items()
    ]
    return tuple(sorted(pooled, key=lambda carrier: -carrier.fraction))
