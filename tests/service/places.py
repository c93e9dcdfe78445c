"""Places of workers, looked at from outside."""

from __future__ import annotations

from hdprog.service.slots import Places


def is_free(places: Places, name: str) -> bool:
    with places.hold(name) as hold:
        return hold is not None
