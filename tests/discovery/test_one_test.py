"""A drive with one test is a record that was searched by itself."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from hdprog import tests_of_drive
from hdprog.discovery.drive import _considered
from hdprog.explanation import ConsideredEffect

CREEP = ConsideredEffect("creep", "grows", 2.0, 1.0, 0.5, "no evidence")


@pytest.mark.parametrize("count", [1, 2])
def test_the_best_that_was_not_added_is_weighed(
    monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    asked: list[bool] = []
    stand_in = SimpleNamespace(of=lambda *_: SimpleNamespace(posterior=None))
    monkeypatch.setattr(tests_of_drive, "FittedTest", stand_in)
    for name in ("sample_base", "sample_final"):
        monkeypatch.setattr(tests_of_drive, name, lambda *_: None)
    monkeypatch.setattr(
        tests_of_drive, "explain", lambda *_, weigh_others, **__: asked.append(weigh_others)
    )
    test = SimpleNamespace(test_id="t01", service_hours=0.0)
    folder = cast("Any", SimpleNamespace(tests=[test] * count))
    seeds = tests_of_drive.np.random.SeedSequence(1).spawn(count)
    fits = [cast("Any", None)] * count
    _, closing = tests_of_drive.fit_and_close(folder, fits, seeds, cast("Any", None), None)
    list(closing)
    assert asked == [count == 1] * count


def test_its_reasons_stand_as_they_are() -> None:
    closed = SimpleNamespace(explanation=SimpleNamespace(considered=(CREEP,)))
    assert _considered([], [cast("Any", closed)], set()) == (CREEP,)


def test_of_several_tests_it_is_told_how_many_cannot_show_an_effect() -> None:
    """Creep by the timed test alone, a kinematic error by none."""
    missing: list[dict[str, tuple[str, ...]]] = [{}, {"creep": ("time",)}]
    model = SimpleNamespace(log_evidence=0.0, worth=1.0, ids=())
    grown = SimpleNamespace(log_evidence=1.0, ids=("creep",))
    traced = [
        SimpleNamespace(
            steps=[SimpleNamespace(before=model, models={} if lacking else {"creep": grown})],
            mechanisms=model,
            final=model,
            missing={**lacking, "kinematic_error": ("output angle",)},
        )
        for lacking in missing
    ]
    ripple = replace(CREEP, id="kinematic_error", log_evidence_gain=None)
    closed = SimpleNamespace(explanation=SimpleNamespace(considered=(CREEP, ripple)))
    creep, kinematic = _considered(cast("Any", traced), [cast("Any", closed)] * 2, set())
    assert creep.why_not.endswith("where 5 is asked for; 1 of 2 tests cannot show it")
    assert kinematic.why_not == "cannot be told from any of the 2 tests: they lack output angle"
    assert kinematic.log_evidence_gain is None
