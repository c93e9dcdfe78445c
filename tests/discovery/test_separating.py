"""Which effects are said to do as well as the chosen one, on records that show some of them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from hdprog.discovery.forward_step import Step
from hdprog.discovery.separating import indistinguishable


def step(**gains: float) -> Step:
    """A record on which each effect gains so much log evidence and lowers the misfit by as much."""
    models = {
        name: SimpleNamespace(log_evidence=gain, misfit=100.0 - gain, ids=())
        for name, gain in gains.items()
    }
    before = SimpleNamespace(log_evidence=0.0, worth=1.0, misfit=100.0, ids=())
    return cast(Step, SimpleNamespace(before=before, models=models))


TIMED = step(coulomb_friction=20.0, viscous_friction=21.0, microslip=8.0)
UNTIMED = step(coulomb_friction=20.0, microslip=8.0)


@pytest.mark.parametrize("untimed", [0, 1, 5])
def test_records_that_cannot_show_a_rival_do_not_rule_it_out(untimed: int) -> None:
    """One record without time had silenced what five others say."""
    steps = [TIMED] * 5 + [UNTIMED] * untimed
    assert indistinguishable(steps, "coulomb_friction") == ("viscous_friction",)


def test_a_rival_is_ruled_out_by_the_records_that_show_it() -> None:
    worse = step(coulomb_friction=20.0, viscous_friction=12.0)
    assert indistinguishable([worse] * 2 + [UNTIMED] * 3, "coulomb_friction") == ()


def test_a_record_that_shows_neither_names_no_rival() -> None:
    neither = step(coulomb_friction=0.4, viscous_friction=0.5)
    assert indistinguishable([neither] + [UNTIMED] * 3, "coulomb_friction") == ()
