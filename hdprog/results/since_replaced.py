"""Which tests are of which drive, where a drive was replaced."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar


class _Test(Protocol):
    @property
    def event(self) -> str | None: ...


T = TypeVar("T", bound=_Test)


def since_replaced(tests: Sequence[T]) -> Sequence[T]:
    """Tests of a drive, in order, from the one after it was last replaced; else all."""
    replaced = [at for at, test in enumerate(tests) if test.event == "replaced"]
    return tests[max(replaced, default=0) :]


def lives(events: Sequence[str | None]) -> list[slice]:
    """Which tests, in order, are of each drive that was there, given the events before them."""
    begins = [0, *(at for at, event in enumerate(events) if event == "replaced" and at > 0)]
    ends = [*begins[1:], len(events)]
    return [slice(at, end) for at, end in zip(begins, ends, strict=True)]
