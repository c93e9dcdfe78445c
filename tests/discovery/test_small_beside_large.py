"""A second effect whose share is small only because the first one is large.

Table 2's worn drive with a torque sensor whose zero is off, and with play. A share of the
explained error asked of the play would never be reached.
"""

from __future__ import annotations

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.discovery import search
from hdprog.discovery.pooling import share
from hdprog.discovery.search import (
    CLEAR_EVIDENCE,
    LEFT_OVER_EVIDENCE,
    Traced,
    _left_over,
    trace,
)
from hdprog.discovery.unknown import TermGain
from hdprog.explanation import LeftOver
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from hdprog.physics.parameters import FloatArray
from tests.independent.loops import record_loop
from tests.independent.simulator import POST_TEST as WORN
from tests.independent.simulator import Segment
from tests.physics.table2 import POST_TEST

PRIOR = read_prior_file("csf-25-80").prior(None)
SOME = tuple(BY_ID[name] for name in ("torque_offset", "slip_jump", "creep", "backlash"))


def searched(loop: Loop) -> Traced:
    prepared = prepare(loop, Drive.default(), np.random.default_rng(0), prior=PRIOR)
    return trace([prepared], [np.random.SeedSequence(1)], SOME)[0]


@lru_cache
def with_play(offset: float, play: float, seed: int) -> Traced:
    """±60 Nm and back; the offset in Nm, the play in rad, 5e-6 rad of noise."""
    turns = np.interp(np.arange(400), [0, 80, 240, 399], [0.0, 1.0, -1.0, 1.0])
    torque: FloatArray = np.asarray(60.0 * turns, dtype=np.float64)
    angle = predict(torque, POST_TEST) + 0.5 * play * np.tanh(torque / 0.6)
    angle += 5e-6 * np.random.default_rng(seed).standard_normal(torque.size)
    time: FloatArray = np.linspace(0.0, 40.0, torque.size)
    return searched(Loop(torque + offset, angle, time))


@lru_cache
def settling_offset(play: float) -> Traced:
    """The independent simulator's: an offset that settles, which is not the model's shape."""
    cycle = [Segment(target, 20.0, "ramp", False) for target in (60.0, -60.0, 0.0)]
    cycle += [Segment(60.0, 10.0), Segment(-60.0, 20.0), Segment(60.0, 20.0)]
    effects = {"torque_offset": 2e-4} | ({"backlash": play} if play else {})
    record = record_loop(WORN, cycle, 400, np.random.default_rng(0), effects=effects)
    return searched(Loop(record.torque, record.angle, record.time))


@pytest.mark.parametrize(("offset", "play"), [(3.0, 1.5e-4), (1.5, 1.5e-4), (3.0, 1.1e-4)])
def test_play_is_named_beside_an_offset_that_carries_nearly_all(offset: float, play: float) -> None:
    found = with_play(offset, play, 0)
    assert set(found.final.ids) == {"torque_offset", "backlash"}
    _, second, last = found.steps
    assert share([found.base], [second.before], [last.before]) < 0.01
    assert second.gains["backlash"] > CLEAR_EVIDENCE
    assert found.left_over is None
    assert found.final.term is None


def test_an_offset_alone_explains_its_record() -> None:
    found = with_play(3.0, 0.0, 0)
    assert found.final.ids == ("torque_offset",)
    assert found.left_over is None
    assert found.final.term is None


def test_an_offset_of_another_shape_gets_no_second_name() -> None:
    found = settling_offset(0.0)
    assert found.final.ids == ("torque_offset",)
    assert found.left_over is None


@pytest.mark.parametrize(
    ("left", "believed"), [(12.0, False), (6.0, False), (3.0, True), (1.8, True)]
)
def test_the_share_that_is_asked_for_is_smaller_the_more_is_cleared_up(
    left: float, believed: bool
) -> None:
    """Misfits 1500, then 25 beside the first effect; the second may carry 1.6 % of it at most."""
    base, before, after = ([SimpleNamespace(least_misfit=one)] for one in (1500.0, 25.0, left))
    assert search._carries(base, before, after) == believed  # type: ignore[arg-type]


def test_what_is_refused_for_its_share_is_told_and_not_named() -> None:
    """Play beside an offset whose own shape leaves more than noise."""
    found = settling_offset(1e-4)
    assert found.final.ids == ("torque_offset",)
    assert found.left_over is not None
    assert found.left_over.id == "backlash"
    assert found.left_over.log_evidence_gain > CLEAR_EVIDENCE > LEFT_OVER_EVIDENCE
    assert found.final.term is None


def test_a_curve_that_is_left_over_is_told_with_its_own_evidence() -> None:
    """One over time must pass a higher threshold, for noise looks like it; its evidence is its."""

    def told(**gains: float) -> LeftOver | None:
        return _left_over([], [{name: TermGain(name, gain, True) for name, gain in gains.items()}])

    assert told(time=20.0, torque=10.5) == LeftOver("unknown", "time", 20.0)
    assert told(time=20.0, torque=12.0) == LeftOver("unknown", "torque", 12.0)
    assert told(time=18.0, torque=9.0) is None
