"""What counts as a number in a file: digits, point, exponent; no nan, inf, 1_000 or 0x10."""

from __future__ import annotations

import re

__all__ = ["is_number", "may_hold_thousands"]

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:(?:,\d{3})+|(?:\.\d{3})+)", re.ASCII)


def is_number(text: str) -> bool:
    """Tell whether a text without white space around it is a number with a decimal point."""
    return _NUMBER.fullmatch(text) is not None


def may_hold_thousands(text: str) -> bool:
    """Tell whether a number's commas or points may part thousands: 12,500 is 12500, or 12.5."""
    return _THOUSANDS.fullmatch(text) is not None
