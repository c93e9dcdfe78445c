"""Numbers as people type them into forms."""

from __future__ import annotations

from hdprog.data.numbers import is_number, may_hold_thousands
from hdprog.errors import BadInputError


def number_of(text: str, where: str) -> float:
    """Read a number; a comma may stand before its decimals.

    Raises
    ------
    BadInputError
        for commas that may stand between thousands: 12,500 is 12500 to one and 12.5 to another
    ValueError
        for text that is no number in a file either
    """
    if may_hold_thousands(text):
        whole, _, decimals = text.rpartition(",")
        plain = text.replace(",", "")
        raise BadInputError(
            f"the text {text[:40]!r}, whose comma may stand between thousands or before decimals",
            where,
            f"a number without it, such as {plain[:40]} or {plain[:40]}.0",
            "Leave the comma out."
            if "," in whole
            else f"Leave the comma out, or write {whole}.{decimals} with a point if that is meant.",
        )
    plain = text.strip().replace(",", ".")
    if not is_number(plain):
        raise ValueError(text)
    return float(plain)
