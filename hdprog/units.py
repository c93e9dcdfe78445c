"""Units in column headers and their conversion to SI. A unit is read or refused, never guessed.

SI inside hdprog: Nm, rad, s, and °C for temperature.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ISO_8601",
    "Dimension",
    "Header",
    "Unit",
    "find_unit",
    "known_units",
    "normalise_name",
    "parse_header",
]

Dimension = Literal["torque", "angle", "time", "temperature"]

_POUND_FORCE = 4.4482216152605  # N, exact by definition
_INCH = 0.0254  # m, exact
_FOOT = 0.3048  # m, exact
_KILOGRAM_FORCE = 9.80665  # N, exact


@dataclass(frozen=True)
class Unit:
    """A unit that a column may be recorded in.

    Parameters
    ----------
    name : str
        The spelling used in messages.
    dimension : {"torque", "angle", "time", "temperature"}
        What it measures.
    factor, offset : float
        Value in SI (°C for temperature) = factor · value + offset.
    """

    name: str
    dimension: Dimension
    factor: float
    offset: float = 0.0

    def to_si(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert recorded values, of any shape, to Nm, rad, s or °C."""
        converted = values * self.factor
        return converted + self.offset if self.offset else converted


ISO_8601 = Unit("ISO 8601", "time", math.nan)
"""Marks a column of dates and times written as ISO 8601; it has no factor."""

# Each unit with its spellings. Spellings are compared after `_squash`, which drops the signs
# between factors, so "Nm" also stands for "N·m", "N m", "N-m", "N*m" and "N.m"; it also makes two
# primes of a double one.
_UNITS: tuple[tuple[Unit, tuple[str, ...]], ...] = (
    (Unit("Nm", "torque", 1.0), ("Nm", "newtonmetre", "newtonmetres", "newtonmeter")),
    (Unit("kNm", "torque", 1e3), ("kNm",)),
    (Unit("MNm", "torque", 1e6), ("MNm",)),
    (Unit("mNm", "torque", 1e-3), ("mNm",)),
    (Unit("Ncm", "torque", 1e-2), ("Ncm",)),
    (Unit("Nmm", "torque", 1e-3), ("Nmm",)),
    (
        Unit("in·lbf", "torque", _INCH * _POUND_FORCE),
        ("inlbf", "lbfin", "inlb", "lbin", "inlbs", "inchlbf"),
    ),
    (
        Unit("ft·lbf", "torque", _FOOT * _POUND_FORCE),
        ("ftlbf", "lbfft", "ftlb", "lbft", "ftlbs", "footlbf"),
    ),
    (Unit("kgf·m", "torque", _KILOGRAM_FORCE), ("kgfm",)),
    (Unit("kgf·cm", "torque", _KILOGRAM_FORCE * 1e-2), ("kgfcm",)),
    (Unit("rad", "angle", 1.0), ("rad", "radian", "radians")),
    (Unit("mrad", "angle", 1e-3), ("mrad",)),
    (Unit("urad", "angle", 1e-6), ("urad", "μrad")),
    (Unit("deg", "angle", math.pi / 180), ("deg", "degree", "degrees", "°")),
    (Unit("arcmin", "angle", math.pi / 10_800), ("arcmin", "arcminute", "arcminutes", "′")),
    (Unit("arcsec", "angle", math.pi / 648_000), ("arcsec", "arcsecond", "arcseconds", "′′")),
    (Unit("rev", "angle", 2 * math.pi), ("rev", "revs", "revolution", "revolutions", "turns")),
    (Unit("s", "time", 1.0), ("s", "sec", "secs", "second", "seconds")),
    (Unit("ms", "time", 1e-3), ("ms", "msec", "millisecond", "milliseconds")),
    (Unit("us", "time", 1e-6), ("us", "μs", "microsecond", "microseconds")),
    (Unit("min", "time", 60.0), ("min", "minute", "minutes")),
    (Unit("h", "time", 3600.0), ("h", "hr", "hrs", "hour", "hours")),
    (ISO_8601, ("iso8601", "iso")),
    (Unit("C", "temperature", 1.0), ("C", "°C", "degC", "celsius")),
    (Unit("K", "temperature", 1.0, -273.15), ("K", "kelvin")),
    (
        Unit("F", "temperature", 5 / 9, -160 / 9),
        ("F", "°F", "degF", "fahrenheit"),
    ),
)

_EXACT = {spelling: unit for unit, spellings in _UNITS for spelling in spellings}
_CASELESS: dict[str, Unit] = {}
for _unit, _spellings in _UNITS:
    for _spelling in _spellings:
        # Milli and mega differ by case alone: those spellings count only as written.
        if _spelling.casefold() not in {"mnm", "mrad", "ms"}:
            _CASELESS[_spelling.casefold()] = _unit


# A prefix stands close to its unit: torque_m_Nm may be a measured torque, and is none in mNm.
_APART = re.compile(r"\s*[kMmuμµ][\s·⋅∙•×*.\-_]")


def _squash(text: str) -> str:
    """Drop what may stand between the factors of a unit, and unify look-alike characters."""
    text = unicodedata.normalize("NFKC", text.replace("º", "°").replace("µ", "μ"))
    return re.sub(r"[\s·⋅∙•×*.\-_]+", "", text)


def find_unit(text: str) -> Unit | None:
    """Return the unit that `text` spells, or None where there is no such unit.

    Upper and lower case count only where they change the meaning (mNm and MNm).
    """
    if _APART.match(text):
        return None
    squashed = _squash(text)
    return _EXACT.get(squashed) or _CASELESS.get(squashed.casefold())


def known_units(dimension: Dimension) -> tuple[str, ...]:
    """Return the names of all units of a dimension, for messages."""
    return tuple(unit.name for unit, _ in _UNITS if unit.dimension == dimension)


def normalise_name(text: str) -> str:
    """Return a column name in lower case with one underscore between words."""
    text = unicodedata.normalize("NFKC", text).casefold()
    return re.sub(r"[\W_]+", "_", text).strip("_")


@dataclass(frozen=True)
class Header:
    """One column header taken apart.

    Parameters
    ----------
    text : str
        As found in the file.
    name : str
        What is measured, in lower case: ``"torque"``.
    unit_text : str
        The unit as written, empty where there is none.
    unit : Unit or None
        The unit, or None where none is written or the one written is not known.
    """

    text: str
    name: str
    unit_text: str
    unit: Unit | None


_BRACKETED = re.compile(r"^(?P<name>.*?)\s*(?:\[(?P<a>[^\[\]]*)\]|\((?P<b>[^()]*)\))\s*$")


def parse_header(text: str) -> Header:
    """Take a column header apart into a name and a unit.

    Understood: ``torque_Nm``, ``Torque [Nm]``, ``torque (N m)``, ``Torque in Nm``,
    ``torque / Nm``, ``torque, Nm``, ``torque Nm``.

    Parameters
    ----------
    text : str
        The header of one column.

    Returns
    -------
    Header
        With ``unit`` None where no unit is written or it is not known.
    """
    text = text.strip()
    bracketed = _BRACKETED.match(text)
    if bracketed:
        unit_text = (bracketed["a"] or bracketed["b"] or "").strip()
        return Header(text, normalise_name(bracketed["name"]), unit_text, find_unit(unit_text))
    for name, unit_text in _splits(text):
        unit = find_unit(unit_text)
        if unit is not None and normalise_name(name):
            return Header(text, normalise_name(name), unit_text, unit)
    return Header(text, normalise_name(text), "", None)


def _splits(text: str) -> Iterator[tuple[str, str]]:
    """Yield (name, rest) at each separator, the longest rest first: in_lbf comes before lbf."""
    for separator in re.finditer(r"\s+in\s+|\s*[/,:]\s*|[\s_\-]+", text):
        yield text[: separator.start()], text[separator.end() :]
