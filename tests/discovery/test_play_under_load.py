"""Play whose sides change at a torque that is not zero: a coupling that carries a load.

A bump whose teeth have softened to make up for it stood in for such play, and was taken for a
damaged tooth.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.discovery import found as finding
from hdprog.discovery.found import advice_on
from hdprog.discovery.search import Traced, trace
from hdprog.inference.effect_starts import strained
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from hdprog.physics.parameters import FloatArray
from tests.physics.table2 import INITIAL

PRIOR = read_prior_file("csf-25-80").prior(None)
SOME = tuple(BY_ID[name] for name in ("torque_offset", "backlash", "asymmetry", "tooth_damage"))


def record(added: FloatArray, torque: FloatArray) -> Loop:
    """With 5e-6 rad of noise."""
    noise = 5e-6 * np.random.default_rng(3).standard_normal(torque.size)
    return Loop(torque, predict(torque, INITIAL) + added + noise, np.arange(float(torque.size)))


@lru_cache
def searched(effect: str) -> Traced:
    """±63 Nm and back."""
    torque: FloatArray = np.interp(np.arange(400), [0, 80, 240, 399], [0.0, 63.0, -63.0, 63.0])
    shape = {
        "play": 0.5 * np.tanh((torque - 6.0) / 0.6),
        "tooth": np.exp(-0.5 * ((torque - 22.0) / 2.5) ** 2),
    }
    loop = record(1.2e-4 * shape[effect], torque)
    prepared = prepare(loop, Drive.default(), np.random.default_rng(0), prior=PRIOR)
    return trace([prepared], [np.random.SeedSequence(1)], SOME)[0]


def values(traced: Traced, effect: str) -> Mapping[str, float]:
    final = traced.final
    found = final.likelihood.effect_values(final.start.point[None])[effect]
    return {name: float(value[0, 0]) for name, value in found.items()}


def test_it_is_named_play_with_its_centre() -> None:
    traced = searched("play")
    assert traced.final.ids == ("backlash",)
    found = values(traced, "backlash")
    assert found["play"] == pytest.approx(1.2e-4, rel=0.1)
    assert found["centre"] == pytest.approx(6.0, abs=0.3)
    assert not strained(traced.final.likelihood, traced.final.start).any()


def test_a_bump_is_a_tooth_and_told_from_play() -> None:
    traced = searched("tooth")
    assert traced.final.ids == ("tooth_damage",)
    assert values(traced, "tooth_damage")["centre"] == pytest.approx(22.0, abs=0.5)
    tooth = BY_ID["tooth_damage"]
    assert advice_on(tooth, [traced.steps[0]]) == tooth.advice


@pytest.mark.parametrize(
    ("offered", "as_good", "told"),
    [
        (("backlash", "creep"), (), True),
        (("backlash", "creep"), ("creep",), True),
        (("backlash", "creep"), ("backlash",), False),
        (("creep",), (), False),  # a one-sided record cannot show play
    ],
)
def test_no_alarm_where_play_is_not_ruled_out(
    offered: tuple[str, ...], as_good: tuple[str, ...], told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(finding, "indistinguishable", lambda *_: as_good)
    step = SimpleNamespace(models=dict.fromkeys((*offered, "tooth_damage")))
    advice = advice_on(BY_ID["tooth_damage"], [step])  # type: ignore[list-item]
    assert ("something else" in advice) == (not told)
    assert ("do not wait" in advice) == told


def test_others_have_one_advice() -> None:
    for effect in BY_ID.values():
        assert bool(effect.rivals) == bool(effect.unsure_advice)
        assert effect.rivals <= set(BY_ID)
    assert advice_on(BY_ID["creep"], []) == BY_ID["creep"].advice
