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
        sign, name = (",", "comma") if "," in text else (".", "point")
        whole, _, decimals = text.rpartition(sign)
        plain = text.replace(sign, "")
        meant = f"{whole}.{decimals}" if sign == "," else f"{whole}.{decimals}0"
        raise BadInputError(
            f"the text {text[:40]!r}, whose {name} may stand between thousands or before decimals",
            where,
            f"a number without it, such as {plain[:40]} or {plain[:40]}.0",
            f"Leave the {name} out."
            if sign in whole
            else f"Leave the {name} out, or write {meant} if that is meant.",
        )
    plain = text.strip().replace(",", ".")
    if not is_number(plain):
        raise ValueError(text)
    return float(plain)
