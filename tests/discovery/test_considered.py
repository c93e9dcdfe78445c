"""Why an effect was not added: what is said has to be what was decided by."""

from __future__ import annotations

import pytest

from hdprog.discovery.considered import cannot_be_told, why_not


@pytest.mark.parametrize(
    ("gains", "final", "curve", "decided", "said"),
    [
        ([{"creep": 2.0}], (), False, True, "no evidence: log Bayes factor 2.0"),
        ([{"creep": 5.5}], (), True, True, "5.5, less than an empirical term gains"),
        ([{"creep": 5.5}], (), False, False, "5.5 on this test, too little over all tests"),
        ([{"creep": 5.5}], (), True, False, "5.5 on this test, too little over all tests"),
        (
            [{"creep": 9.0, "backlash": 30.0}, {"creep": 6.0}],
            ("backlash",),
            False,
            True,
            "6.0 beside backlash, but it would carry too little of the error",
        ),
        (
            [{"creep": 9.0, "backlash": 30.0}, {"creep": 6.0}],
            ("backlash",),
            False,
            False,
            "but over all tests it gains too little, or it would carry too little of the error",
        ),
        (
            [{"creep": 9.0, "backlash": 30.0}, {"creep": 0.5}],
            ("backlash",),
            False,
            True,
            "9.0 where 30.0 was reached; beside backlash it gains nothing more (0.5)",
        ),
        (
            [{"creep": 9.0, "coulomb_friction": 30.0}, {"creep": 0.5}],
            ("coulomb_friction",),
            False,
            True,
            "beside Coulomb friction it gains nothing more",
        ),
    ],
)
def test_reasons(
    gains: list[dict[str, float]], final: tuple[str, ...], curve: bool, decided: bool, said: str
) -> None:
    assert said in why_not("creep", gains, (), final, curve, decided=decided)


def test_what_was_taken_or_gained_later_had_evidence() -> None:
    """Masked at first, by an effect that was added then."""
    gains = [{"creep": 3.0, "backlash": 50.0}, {"creep": 40.0}]
    taken = why_not("creep", gains, ("backlash", "creep"), (), True, decided=True)
    assert "carries part of the error only" in taken
    beside = why_not("creep", gains, ("backlash",), ("backlash",), False, decided=True)
    assert "40.0 beside backlash" in beside


@pytest.mark.parametrize(
    ("second", "lack"),
    [(["a rate"], "a rate"), (["a rate", "time"], "a rate"), (["an angle"], "a rate or an angle")],
)
def test_several_tests_lack_what_all_of_them_do(second: list[str], lack: str) -> None:
    assert cannot_be_told([["a rate"], second]).endswith(f"of the 2 tests: they lack {lack}")
