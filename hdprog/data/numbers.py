"""What counts as a number in a file: digits, point, exponent; no nan, inf, 1_000 or 0x10."""

from __future__ import annotations

import re

__all__ = ["is_number"]

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


def is_number(text: str) -> bool:
    """Tell whether a text without white space around it is a number with a decimal point."""
    return _NUMBER.fullmatch(text) is not None
