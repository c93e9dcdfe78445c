"""Which candidates are worth a thorough search."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from hdprog.discovery.forward_step import Step, _promising


def look(gains: dict[str, float], free: float) -> Step:
    """A first look at a record: gains by candidate, and of an empirical term."""
    before: Any = SimpleNamespace(log_evidence=100.0)
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
