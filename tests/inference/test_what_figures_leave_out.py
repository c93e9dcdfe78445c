"""A fit with effects says what its figures leave out, and where a division hangs on a shape."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hdprog.inference import fit_loop
from hdprog.physics.effects import BY_ID
from tests.inference.test_linearised_effects import likelihood_with


@pytest.mark.parametrize(
    ("effects", "divided", "ending"),
    [
        (("backlash",), None, "lasting are given beside them."),
        (("microslip",), "microslip", "Go by width and loss with it."),
        (("microslip", "backlash"), "microslip", "Go by width and loss with it."),
        (("stribeck_friction",), "Stribeck friction", "shapes near it."),
        (("stribeck_friction", "microslip"), "Stribeck friction and microslip", "shapes near it."),
    ],
)
def test_friction_that_divides_by_its_shape_is_told(
    effects: tuple[str, ...], divided: str | None, ending: str
) -> None:
    likelihood, _ = likelihood_with(1.2e-4)
    said = fit_loop._figures_leave_out(
        replace(likelihood, effects=tuple(BY_ID[name] for name in effects))
    )
    assert said.endswith(ending)
    assert ("the assumed shape" in said) == (divided is not None)
    if divided is not None:
        assert f"how much belongs to {divided} hangs" in said
