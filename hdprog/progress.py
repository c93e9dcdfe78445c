"""How far a long computation has come, told to whoever asked for it."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""Called with stage, done, total."""


def untold(stage: str, done: int, total: int) -> None:
    """Tell nobody."""
