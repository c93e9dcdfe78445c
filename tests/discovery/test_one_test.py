"""A drive with one test is a record that was searched by itself."""

from __future__ import annotations

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
