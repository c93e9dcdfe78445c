"""Is this the right drive? A record's stiffness beside that of the drive's earlier tests."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from hdprog.config import Drive
from hdprog.inference.catalogue import times_expected
from hdprog.reporting.rounding import significant

_QUESTION = "Is this the right drive?"
_TELLING = 0.20
_LIKE_TORQUE = 0.20  # tests to other torques have another secant stiffness by nature


def doubt(
    quality: Mapping[str, Any], earlier: Iterable[tuple[str, Mapping[str, Any]]], drive: Drive
) -> str | None:
    """Say how far a record is from what its drive has shown; None where it fits.

    Parameters
    ----------
    quality : read out of the record
    earlier : label and read-out of accepted tests, the newest first
    drive : whose catalogue figure stands in where no test went to a like torque
    """
    stiffness = quality.get("secant_stiffness")
    if not stiffness or stiffness <= 0:
        return None
    for label, other in earlier:
        known = other.get("secant_stiffness")
        if known and known > 0 and abs(_span(quality) / _span(other) - 1.0) < _LIKE_TORQUE:
            return _words(stiffness / known, f"from that of test {label}")
    sides = str(quality.get("sides"))
    ratio = times_expected(drive.model, stiffness, _span(quality), sides)
    # Catalogue figures are means of a make; single drives lie up to a third apart.
    return None if ratio is None else _words(ratio, f"from the catalogue's for {drive.model}", 0.5)


def without_question(words: str) -> str:
    """What makes one doubt, of a record that somebody has answered for."""
    return words.removeprefix(f"{_QUESTION} ")


def _span(quality: Mapping[str, Any]) -> float:
    return float(quality["torque_max"]) - float(quality["torque_min"])


def _words(ratio: float, compared: str, telling: float = _TELLING) -> str | None:
    if abs(ratio - 1.0) < telling:
        return None
    like = 0.5 < ratio < 2.0  # beyond, per cent say little: of a wrong unit they make -100 %
    by = f"{100 * (ratio - 1.0):+.0f} %" if like else f"a factor of {significant(ratio)}"
    return f"{_QUESTION} The stiffness of this record differs by {by} {compared}." + (
        "" if like else " Are the units of torque and angle right?"
    )
