"""Which candidates are worth a thorough search."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from hdprog.data.loop import Loop
from hdprog.discovery.forward_step import Step, _promising, forward_steps
from hdprog.discovery.search import base_model
from hdprog.inference.prepare import prepare
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from tests.discovery.test_unknown import DRIVE, PRIOR, TIME, TORQUE
from tests.physics.table2 import POST_TEST


def look(gains: dict[str, float], free: float) -> Step:
    """A first look at a record: gains by candidate, and of an empirical term."""
    before: Any = SimpleNamespace(log_evidence=100.0, worth=1.0)
    models = {name: SimpleNamespace(log_evidence=100.0 + gain) for name, gain in gains.items()}
    terms = {"torque": SimpleNamespace(gain=free)}
    return Step(before, cast(Any, models), cast(Any, terms))


SEEN = {"creep": 40.0, "viscous": 36.0, "microslip": 20.0, "drift": 8.0, "ripple": 4.0, "jump": 0.1}


def test_rivals_of_a_leader_of_all_records_are_looked_at_twice() -> None:
    other = {**SEEN, "ripple": 60.0}
    assert _promising([look(SEEN, 10.0), look(SEEN, 10.0), look(other, 10.0)]) == [
        ["creep", "viscous"],
        ["creep", "viscous"],
        ["creep", "viscous"],
    ]


def test_without_a_leader_every_record_looks_for_itself() -> None:
    # A free function does better: the best mode of the right effect may be missed in all records.
    assert (
        _promising([look(SEEN, 50.0)] * 3)
        == [["creep", "viscous", "microslip", "drift", "ripple"]] * 3
    )


def test_one_record_looks_at_the_best_four() -> None:
    assert _promising([look(SEEN, 10.0)]) == [["creep", "viscous", "microslip", "drift"]]


def test_where_nothing_is_nothing_is_looked_at() -> None:
    assert _promising([look({"creep": 1.0}, -3.0)] * 3) == [[], [], []]


def test_models_keep_their_identity_through_other_processes() -> None:
    """What comes back from a worker is a copy; the step is about the caller's own model."""
    rng = np.random.default_rng(1)
    loop = Loop(TORQUE, predict(TORQUE, POST_TEST) + 1e-5 * rng.standard_normal(TORQUE.size), TIME)
    model = base_model(prepare(loop, DRIVE, rng, prior=PRIOR), rng)

    def copied(function: Callable[..., Any], *arguments: Iterable[Any]) -> list[Any]:
        return [
            pickle.loads(pickle.dumps(function(*each))) for each in zip(*arguments, strict=False)
        ]

    (step,) = forward_steps([model], [[BY_ID["backlash"]]], [], [rng], copied, None)
    assert step.before is model
