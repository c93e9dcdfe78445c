"""An angle recorded in steps wider than its noise leaves a pattern that is no effect."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.data.loop import Loop
from hdprog.discovery import model
from hdprog.discovery.explain import remark_on_steps
from hdprog.discovery.model import Model
from hdprog.discovery.search import trace
from hdprog.inference.prepare import Prepared, prepare
from hdprog.physics.effects import BY_ID
from tests.discovery.test_search import DRIVE, PRIOR
from tests.independent.loops import random_loop


@pytest.mark.parametrize(("noise", "told"), [(5e-6, True), (2e-5, False)])
def test_steps_that_are_most_of_the_error_are_named(noise: float, told: bool) -> None:
    """Of 40 µrad: 11.5 µrad of 12.6, and of 23.1 µrad."""
    step = 4e-5
    branch = np.linspace(-2.7e-3, 2.7e-3, 271)
    smooth = np.concatenate([branch, branch[::-1]])
    smooth = smooth + noise * np.random.default_rng(1).standard_normal(smooth.size)
    error = float(np.hypot(noise, step / np.sqrt(12)))
    found = remark_on_steps(step * np.round(smooth / step), error)
    assert (found is not None) == told
    assert found is None or "steps of 4e-05 rad, which make up most of the error" in found


def test_an_angle_without_steps_has_no_remark() -> None:
    angle = np.random.default_rng(2).standard_normal(400).cumsum() * 1e-5
    assert remark_on_steps(angle, 1e-6) is None


def drawn(seed: int, step: float) -> Prepared:
    """A clean record of the independent simulator, its angle in other steps."""
    record = random_loop(np.random.default_rng(seed), "two-sided")
    loop = Loop(record.torque, step * np.round(record.angle / step), record.time)
    return prepare(loop, DRIVE, np.random.default_rng(1), prior=PRIOR)


@pytest.mark.parametrize("seed", [3, 37])
def test_the_pattern_of_steps_is_given_no_name(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where readings count in full, a curve is given to both."""
    record, effects = drawn(seed, 6e-5), (BY_ID["angle_ripple"], BY_ID["cup_hardening"])

    def named() -> bool:
        final = trace([record], [np.random.SeedSequence(1)], effects)[0].final
        return bool(final.ids) or final.term is not None

    assert not named()
    monkeypatch.setattr(model, "STEPS_EFFECT", 0.0)
    assert named()


@pytest.mark.parametrize(("step", "least", "most"), [(1e-6, 0.99, 1.0), (6e-5, 0.19, 0.6)])
def test_readings_are_worth_less_where_steps_are_wide(
    step: float, least: float, most: float
) -> None:
    record = drawn(3, step)
    assert least < Model(record.likelihood, tuple(record.starts)).worth <= most
