"""Chains that start far apart on a ridge come to one place, and without paths they do not.

R-hat compares chains that all start at the Gaussian step: what none of them enters it cannot tell.
"""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.physics.parameters import NAMES
from hdprog.trend import joint_chains
from hdprog.trend.gaussian_step import Tangents
from hdprog.trend.hyperparameters import HyperparameterDraws
from hdprog.trend.joint_chains import Chains
from hdprog.trend.ridge_paths import RidgePath, ridge_paths
from tests.trend.stand_in import NEW, WEAR
from tests.trend.two_tests import FIXED, Problem, worn_by

K_F = NAMES.index("K_F")
CHAINS, DROPPED, KEPT = 24, 10, 20
FAR = 2.0  # spreads of the cups, either way


@pytest.fixture(scope="module")
def nearly_new() -> Problem:
    """Six tests of a drive with hardly any threshold: cup and teeth are one stiffness."""
    return worn_by([0.05, 0.08, 0.1, 0.15, 0.2, 0.2], NEW + 0.1 * WEAR)


def cups(problem: Problem, start: np.ndarray, paths: tuple[RidgePath, ...]) -> np.ndarray:
    """log K_F of the last test, from chains that all start at one state (tests, 8)."""
    states = np.repeat(start[None], CHAINS, axis=0)
    none = tuple(np.empty((CHAINS, 0)) for _ in problem.tests)
    known = HyperparameterDraws(np.tile(FIXED, (4, 100, 24, 1)), 1.0, 1e4, 1e4, converged=True)
    deviates, rng = np.repeat(FIXED, CHAINS, axis=0), np.random.default_rng(3)
    chains = Chains(problem.step, known, deviates, Tangents(states, none), 4, rng, paths)
    found = []
    for number in range(DROPPED + KEPT):
        chains.sweep()
        if number >= DROPPED:
            found.append(chains.met[:, -1, K_F])
    return np.concatenate(found)


@pytest.mark.parametrize("along", [True, False])
def test_from_soft_and_from_stiff_cups_they_come_to_one_place(
    nearly_new: Problem, monkeypatch: pytest.MonkeyPatch, along: bool
) -> None:
    """By four seeds they end at most 0.5 spreads apart, and 1.3 and more without paths."""
    # The hyperparameters are held.
    monkeypatch.setattr(Chains, "_vary_hyperparameters", lambda chains: None)
    monkeypatch.setattr(joint_chains, "_FOLLOWED", 0)
    paths = ridge_paths(nearly_new.step, FIXED[0])
    path = next(one for one in paths if one.share[K_F])
    middle = np.stack([test.point for test in nearly_new.step.tests])[None]
    ends = [
        (middle + path.along(middle, np.array([way * FAR * path.spread])).states)[0]
        for way in (-1.0, 1.0)
    ]
    low, high = (cups(nearly_new, end, paths if along else ()) for end in ends)
    apart = abs(low.mean() - high.mean()) / np.sqrt(0.5 * (low.var() + high.var()))
    assert (apart < 0.7) == along
