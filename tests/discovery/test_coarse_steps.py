"""An angle recorded in steps wider than its noise leaves a pattern that is no effect."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.discovery.explain import remark_on_steps


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
