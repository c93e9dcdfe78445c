"""What temperature changes in a drive, and its tests as they would be at the reference."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.physics.figures import FigureRequest, Operation
from hdprog.physics.parameters import FloatArray
from hdprog.results import TemperatureEffect, by_level
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.kalman_filter import per_step_of_warmth
from hdprog.trend.state_space import Hyperparameters
from hdprog.trend.temperature import STEP_K, Temperatures, Warming
from hdprog.trend.trend import Trend
from hdprog.trend.wear_coordinates import from_loop, to_loop


def temperature_effect(
    trend: Trend,
    requests: Sequence[FigureRequest],
    operation: Operation,
    rng: np.random.Generator,
    draws: int,
) -> TemperatureEffect | None:
    """How far 10 K move each figure of the drive as it is now; None where tests do not differ."""
    found = Temperatures.of(trend.tests)
    if found is None:
        return None
    now = trend.wandering_paths(np.array([trend.now_hours]), rng, draws)
    moved = {}
    for request in requests:
        cool, warm = (
            figure_paths(request, to_loop(state), trend.prior, operation, trend.followed)
            for state in (now.states[:, 0], now.states[:, 0] + now.warmer)
        )
        if not (cool > 0.0).all():
            continue  # of a width of exactly 0, where the teeth never slip, there are no per cent
        moved[request.key] = by_level(100.0 * (warm / cool - 1.0))
    return TemperatureEffect(
        found.reference_C, STEP_K * found.spread, int(found.unknown.sum()), moved
    )


def warmth_added(trend: Trend, rng: np.random.Generator, draws: int) -> FloatArray | None:
    """Draw what its temperature added to the state at each test, (draws, tests, n).

    Of a test of unknown temperature it is its prior. None where temperature does not count.
    """
    found = Temperatures.of(trend.tests)
    if found is None:
        return None
    met = trend.met.thinned(draws, rng)
    given = trend.given(Hyperparameters.of(met.deviates, trend.wear_prior))
    steps = given.steps
    warming = Warming.of(found, steps.begins, trend.wear_prior)
    first = np.flatnonzero(steps.begins).tolist()
    added = []
    # A replaced drive has its own change by 10 K, which its own tests tell.
    for start, end in zip(first, [*first[1:], len(trend.tests)], strict=True):
        course = given.draw_behind(met.measured, steps.upto(end), np.arange(end), rng)
        warmer = per_step_of_warmth(steps, course.carried)
        doubt = np.sqrt(warming.doubt[start:end])
        warmth = warming.warmth[start:end] + doubt * rng.standard_normal((draws, end - start))
        added.append(warmth[..., None] * warmer[:, None])
    return np.concatenate(added, axis=1)


def cooled(coordinates: FloatArray, added: FloatArray) -> FloatArray:
    """Draws (draws, n) from a test's own posterior, less what temperature added (others, n)."""
    repeated = added[np.arange(len(coordinates)) % len(added)]
    return to_loop(from_loop(coordinates) - repeated)
