"""Texts that are alike but for their numbers, said once with the range of each number."""

from __future__ import annotations

import re
from collections.abc import Sequence

from hdprog.reporting.rounding import MINUS

# A number by itself, not a part of a name such as K1 or t07; thin or plain spaces by thousands.
_NUMBER = re.compile(
    r"(?<![\w.@-])\u2212?\d+(?:[\u2009\u202f\u00a0 ]\d{3}(?!\d))*(?:\.\d+)?(?![\w.]*[A-Za-z_])"
)


def shape_of(text: str) -> str:
    """The text without its numbers: texts of one shape can be joined."""
    return _NUMBER.sub("\0", text)


def joined(texts: Sequence[str]) -> str:
    """Texts of one shape as one text, each number that differs as its range."""
    numbers = zip(*(_NUMBER.findall(text) for text in texts), strict=True)
    ranges = iter([_range(each) for each in numbers])
    return _NUMBER.sub(lambda _: next(ranges), texts[0])


def _range(numbers: Sequence[str]) -> str:
    least, most = min(numbers, key=_value), max(numbers, key=_value)
    return least if _value(least) == _value(most) else f"{least} to {most}"


def _value(number: str) -> float:
    return float(re.sub(r"\s", "", number).replace(MINUS, "-"))
