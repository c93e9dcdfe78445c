"""Mechanisms, a curve, or both: which of them is kept."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hdprog.discovery import empirical


def model(misfit: float, log_evidence: float, *ids: str) -> Any:
    return SimpleNamespace(misfit=misfit, log_evidence=log_evidence, worth=1.0, ids=ids)


BASE, ALONE = model(1500.0, 0.0), model(400.0, 90.0)


@pytest.mark.parametrize(
    ("left", "gain", "both", "left_both", "kept"),
    [
        # An encoder's low-pass, most of it viscous friction: without it the width came out double.
        (560.0, 66.0, 110.0, 380.0, "both"),
        (560.0, 66.0, 93.0, 380.0, "alone"),
        # By noise with a memory, which takes over what they leave.
        (560.0, 66.0, 110.0, 480.0, "alone"),
        # A dip of the stiffness, which a ripple follows: the curve has no use for it.
        (560.0, 66.0, 80.0, 380.0, "alone"),
        # A bump on one branch, of which damaged teeth carry a third.
        (1100.0, 20.0, 110.0, 380.0, "alone"),
    ],
)
def test_a_mechanism_stays_beside_a_curve_that_wants_it(
    left: float,
    gain: float,
    both: float,
    left_both: float,
    kept: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mechanism, wider = model(left, gain, "one"), model(left_both, both, "one")
    term = {"torque": SimpleNamespace(gain=30.0)}

    def with_term(models: list[Any], *_: object) -> list[Any]:
        return [wider] if models == [mechanism] else [ALONE]

    monkeypatch.setattr(empirical, "_with_term", with_term)
    monkeypatch.setattr(empirical, "term_gains", lambda _: term)
    found = empirical.with_unknown([BASE], [mechanism], [term], [np.random.default_rng(0)], map)  # type: ignore[list-item]
    assert found == [wider if kept == "both" else ALONE]


@pytest.mark.parametrize(
    ("left", "gain", "kept"),
    [
        # Noise alone, and no curve gains anything.
        (410.0, -3.0, "mechanism"),
        # A little is left to gain: a dead band on one branch was taken for a damaged tooth.
        (410.0, 1.0, "alone"),
        # More than noise is left, whatever a curve over one coordinate gains.
        (520.0, -3.0, "alone"),
    ],
)
def test_a_curve_in_a_mechanisms_place_is_tried_unless_noise_alone_is_left(
    left: float, gain: float, kept: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mechanism, alone = model(left, 66.0, "one"), model(340.0, 90.0)
    mechanism.likelihood = SimpleNamespace(blocks=400)
    remaining, own = ({"torque": SimpleNamespace(gain=value)} for value in (gain, 30.0))

    def with_term(models: list[Any], *_: object) -> list[Any]:
        assert kept == "alone"  # else it is not worth its time
        return [mechanism] if models == [mechanism] else [alone]

    monkeypatch.setattr(empirical, "_with_term", with_term)
    monkeypatch.setattr(empirical, "term_gains", lambda _: own)
    found = empirical.with_unknown(
        [BASE],
        [mechanism],
        [remaining],  # type: ignore[list-item]
        [np.random.default_rng(0)],
        map,
    )
    assert found == [mechanism if kept == "mechanism" else alone]
