"""Is this the right drive? Asked where the stiffness differs, and only there."""

from __future__ import annotations

from typing import Any

import pytest

from hdprog.config import Drive
from hdprog.service.same_drive import doubt


def read_out(stiffness: float, torque: float = 63.0) -> dict[str, Any]:
    return {
        "secant_stiffness": stiffness,
        "torque_max": torque,
        "torque_min": -torque,
        "sides": "two-sided",
    }


@pytest.mark.parametrize(("stiffness", "asked"), [(4e4, False), (3.3e4, False), (2.8e4, True)])
def test_beside_earlier_tests(stiffness: float, asked: bool) -> None:
    found = doubt(read_out(stiffness), [("t02", read_out(4e4)), ("t01", read_out(1e4))], Drive())
    assert (found is not None) == asked
    if stiffness == 2.8e4:
        assert found is not None
        assert "differs by -30 %" in found
        assert "test t02" in found


@pytest.mark.parametrize(
    ("stiffness", "said"),
    [(4e7, "a factor of 1\u202f000 from"), (40.0, "a factor of 0.00100 from")],
)
def test_a_wrong_unit_is_a_factor(stiffness: float, said: str) -> None:
    found = doubt(read_out(stiffness), [("t01", read_out(4e4))], Drive())
    assert found is not None
    assert said in found
    assert "units" in found


def test_tests_to_other_torques_do_not_compare() -> None:
    assert doubt(read_out(2e4, 20.0), [("t01", read_out(4e4))], Drive()) is None


def test_beside_the_catalogue_where_nothing_else_compares() -> None:
    drive = Drive(model="CSF-25-80")
    assert doubt(read_out(4.0e4), [], drive) is None
    found = doubt(read_out(1.5e4), [], drive)
    assert found is not None
    assert "catalogue" in found


def test_a_little_torque_on_the_other_side_does_not_halve_the_peak() -> None:
    """An overshoot at the end of unloading: the record is one-sided all the same."""
    record = {"secant_stiffness": 2e5, "torque_max": 64.0, "torque_min": 0.0, "sides": "one-sided"}
    over = record | {"torque_max": 63.0, "torque_min": -1.0}
    drive = Drive(model="CSF-25-80")
    expected = doubt(record, [], drive)
    assert expected is not None
    assert doubt(over, [], drive) == expected
    assert doubt(over | {"sides": "two-sided"}, [], drive) != expected
