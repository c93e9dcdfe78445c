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


_NO_SIGN = 0.5
"""P-value from which a test tells nothing: those near 1 would outweigh clear ones in the sum. With
even p-values 7 % of drives are then called significant at 5 % by 25 tests, 6 % by 8."""


def joined_p_value(p_values: Sequence[float]) -> float:
    """P-value of all tests together, from that of each; equal ones join to themselves.

    A coordinate that predicts nothing in a test has 1 there, as has much after the correction for
    the number of coordinates: the sum is cut off at that end (Fang et al., Statist. Sinica 33,
    2023), or one such test would silence any number of clear ones.
    """
    if min(p_values) >= _NO_SIGN:
        return float(min(p_values))
    inside = np.clip(p_values, 1e-12, _NO_SIGN)
    return float(0.5 - np.arctan(np.mean(np.tan((0.5 - inside) * np.pi))) / np.pi)


def pooled_carriers(tests: Sequence[Explanation]) -> tuple[Carrier, ...]:
    """Carriers of the residual, largest share first.

    The share of a coordinate is its mean over the tests that have the coordinate; their p-values
    are joined by Cauchy's distribution, whatever hangs together among them (Liu & Xie, J. Am. Stat.
    Assoc. 115, 2020).
    """
    by_name: dict[str, list[Carrier]] = {}
    for test in tests:
        for carrier in test.carried_by:
            by_name.setdefault(carrier.coordinate, []).append(carrier)
    pooled = [
        Carrier(
            name,
            float(np.mean([carrier.fraction for carrier in found])),
            joined_p_value([carrier.p_value for carrier in found]),
        )
        for name, found in by_name.items()
    ]
    return tuple(sorted(pooled, key=lambda carrier: -carrier.fraction))
