"""Chains go on until they have forgotten where they began.

R-hat does not tell a hundred chains that stand still from ones that move: it compares where they
are, and that they were drawn alike is enough.
"""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any, cast

import numpy as np
import pytest

from hdprog.trend.joint_chains import Chains
from hdprog.trend.joint_refit import (
    GROUPS,
    RHAT_LIMIT,
    Effort,
    Met,
    _remembered,
    _run_on,
    _sampled,
)

EFFORT = Effort(24, 96, 75.0, 50.0)
CHAINS = GROUPS * EFFORT.chains


class Walk:
    """Chains of which a part is forgotten each sweep; always with standard normal draws."""

    def __init__(self, forgotten: float) -> None:
        self._rng, self._forgotten = np.random.default_rng(2), forgotten
        self._at = self._rng.standard_normal((CHAINS, 18))

    def sweep(self) -> None:
        kept = np.sqrt(1.0 - self._forgotten**2)
        fresh = self._rng.standard_normal(self._at.shape)
        self._at = kept * self._at + self._forgotten * fresh

    @property
    def deviates(self) -> np.ndarray:
        return self._at[:, :10]

    @property
    def met(self) -> np.ndarray:
        return self._at[:, None, 10:]


def run(forgotten: float) -> Met:
    first: Future[Any] = Future()
    first.set_result(_run_on(cast("Chains", Walk(forgotten)), EFFORT.sweeps))
    return _sampled([first], 0.9, EFFORT, None)


def sweeps_of(met: Met) -> int:
    return len(met.deviates) // CHAINS


@pytest.mark.parametrize("seed", range(5))
def test_of_twenty_quantities_that_are_forgotten_none_is_remembered(seed: int) -> None:
    rng = np.random.default_rng(seed)
    deviates, measured = (
        rng.standard_normal((2, CHAINS, 10)),
        rng.standard_normal((2, CHAINS, 1, 8)),
    )
    assert _remembered(deviates, measured) < 0.35
    deviates[1, :, 3] = deviates[0, :, 3] + 0.5 * rng.standard_normal(CHAINS)
    assert _remembered(deviates, measured) > 0.8
    deviates[:, :, 5] = 0.0  # what is held fixed is not remembered
    assert _remembered(deviates, measured) > 0.8


def test_chains_that_move_end_with_the_first_sweeps() -> None:
    found = run(0.9)
    assert sweeps_of(found) == EFFORT.sweeps
    assert found.converged


def test_chains_that_stand_still_go_on_to_the_bound() -> None:
    """R-hat would have let them end with the first sweeps."""
    found = run(0.02)
    assert sweeps_of(found) == EFFORT.largest_sweeps
    assert found.rhat is not None
    assert found.rhat < RHAT_LIMIT


def test_slow_chains_go_on_until_they_have_forgotten() -> None:
    assert EFFORT.sweeps < sweeps_of(run(0.25)) < EFFORT.largest_sweeps
