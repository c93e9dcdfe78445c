"""Which tests are of the drive that is there now."""

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
