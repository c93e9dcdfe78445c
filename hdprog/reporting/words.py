"""Names of quantities, trend numbers and versions in plain words, with units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from hdprog.physics.parameters import BY_NAME
from hdprog.reporting.reader_units import shown
from hdprog.reporting.rounding import MINUS, THIN_SPACE, interval, plain, significant


@dataclass(frozen=True)
class Quantity:
    """A figure of merit in words.

    Attributes
    ----------
    name : e.g. "secant stiffness at 14 Nm"
    unit : that the reader wants, e.g. "Nm/rad"
    meaning : what it is, in half a sentence
    factor : a value inside hdprog times this is the value in that unit
    """

    name: str
    unit: str
    meaning: str
    factor: float = 1.0

    @property
    def head(self) -> str:
        """Head of a column or label of an axis: name and unit."""
        return f"{self.name} [{self.unit or '?'}]"


_QUANTITIES: Mapping[str, Quantity] = {
    "hysteresis_width_arcmin": Quantity(
        "hysteresis width",
        "arcmin",
        "angle between loading and unloading at zero torque, after a steady cycle to ± the "
        "reference torque",
    ),
    "hysteresis_loss_J": Quantity(
        "hysteresis loss", "J", "energy lost in one steady cycle, the area of the loop"
    ),
    "lost_motion_arcmin": Quantity(
        "lost motion",
        "arcmin",
        "angle on the loop's mid-line between −4 % and +4 % of rated torque",
    ),
    "preload_Nm": Quantity(
        "preload", "Nm", "torque with which the teeth are pressed together at no load"
    ),
    "local_stiffness_Nm_per_rad": Quantity(
        "local stiffness", "Nm/rad", "slope of torque against torsion angle at one torque"
    ),
    "secant_stiffness_Nm_per_rad": Quantity(
        "secant stiffness", "Nm/rad", "torque over the torsion angle that it causes, friction aside"
    ),
    "K1_Nm_per_rad": Quantity(
        "stiffness K1", "Nm/rad", "mean slope up to the catalogue's first torque T1"
    ),
    "K2_Nm_per_rad": Quantity(
        "stiffness K2", "Nm/rad", "mean slope between the catalogue's torques T1 and T2"
    ),
    "K3_Nm_per_rad": Quantity(
        "stiffness K3", "Nm/rad", "mean slope from the catalogue's T2 to the reference torque"
    ),
}

_PERCENT = re.compile(r"(\d) %")
# A hyphen before a digit, unless it joins ("csf-25-80", "18-26") or begins an option.
_HYPHEN = re.compile(r"(?<![\w.)\]-])-(?=\d)")
_MINUS_ZERO = re.compile(rf"{MINUS}(0(?:\.0+)?)(?![\d.]*\d)")
_EXPONENT = re.compile(r"(?<![\w.-])(-?\d(?:\.\d+)?)e([+-]\d{2,3})(?![\w.])")
_DECLARED_DIGITS = 4

PROVISIONAL_NUMBERS = "Not converged: provisional numbers."
QUICK_RUN = "Quick run: fewer draws were made; run again without --quick for a verdict."
FIRST_LIMIT = "first_limit"
"""Key of the forecast of the first of all limits."""


def quantity(key: str) -> Quantity:
    """Name, unit and meaning of a figure of merit by its key, such as `preload_Nm`.

    A key's torque goes into the name; a key that is not known is given back as its own name.
    """
    base, _, torque = key.partition("@")
    known = _QUANTITIES.get(base)
    if known is None:
        return Quantity(base.replace("_", " "), "", "")
    seen = shown(known.unit)
    name = known.name
    if torque:
        name = f"{name} at {torque_words(float(torque.removesuffix('Nm')))}"
    return Quantity(name, seen.unit, known.meaning, seen.factor)


def figure_interval(key: str, low: float, middle: float, high: float) -> tuple[str, str, str]:
    """Three quantiles of a figure of merit in the reader's unit, rounded by their spread."""
    factor = quantity(key).factor
    return interval(factor * low, factor * middle, factor * high)


def threshold_words(key: str, threshold: float) -> str:
    """Limit of a figure with its unit: as declared, or to four digits where it is converted."""
    named = quantity(key)
    if named.factor == 1.0:
        return with_unit(plain(threshold), named.unit)
    return with_unit(significant(named.factor * threshold, _DECLARED_DIGITS), named.unit)


def torque_words(value: float) -> str:
    """Torque, given in Nm, with its unit: as declared, or to three digits as read from a record.

    Nobody declares a torque to five digits: one that has them was read from a record.
    """
    seen = shown("Nm")
    if seen.factor != 1.0:
        return with_unit(significant(seen.factor * value), seen.unit)
    declared = float(f"{value:.{_DECLARED_DIGITS}g}") == value
    return with_unit(plain(value) if declared else significant(value), "Nm")


def with_unit(number: str, unit: str) -> str:
    """Put number and unit on one line; a unit of "-" or "" is left out."""
    return number if unit in ("", "-") else f"{number}{THIN_SPACE}{unit}"


def parameter_name(name: str) -> str:
    """Symbol of a parameter; one that an effect brings is `effect.name` and is kept so."""
    known = BY_NAME.get(name)
    return name if known is None else known.symbol


def parameter_meaning(name: str) -> str:
    """Say what a parameter is and in which unit."""
    known = BY_NAME.get(name)
    if known is None:
        return ""
    return known.meaning if known.unit == "-" else f"{known.meaning}, {shown(known.unit).unit}"


def parameter_unit(name: str) -> str:
    """Unit of a parameter as the reader wants it; empty for a plain number."""
    known = BY_NAME.get(name)
    return "" if known is None or known.unit == "-" else shown(known.unit).unit


def parameter_factor(name: str) -> float:
    """Factor from a parameter's own unit to the reader's."""
    known = BY_NAME.get(name)
    return 1.0 if known is None else shown(known.unit).factor


def capital(sentence: str) -> str:
    """Sentence with its first letter in upper case, the rest as it is."""
    return sentence[:1].upper() + sentence[1:]


def listed(items: Iterable[str], last: str = "and") -> str:
    """Items as "a", "a and b" or "a, b and c"."""
    names = list(items)
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} {last} {names[-1]}"


def counted(count: int, singular: str, plural: str | None = None) -> str:
    """Count and noun: "1 test", "3 tests"."""
    return f"{count} {singular if count == 1 else plural or singular + 's'}"


def contraction_words(contraction: float) -> str:
    """How much a test told of a parameter, in words.

    The contraction is 1 − var(posterior)/var(prior) in the sampled coordinate; below 0.1 the
    posterior is the prior.
    """
    if not contraction >= 0.1:
        return "not informed by this test"
    if contraction < 0.5:
        return "little informed"
    if contraction < 0.9:
        return "informed"
    return "well informed"


def agree(count: int, one: str, several: str) -> str:
    """Form of a word that agrees with a count: "does" for one, "do" for several."""
    return one if count == 1 else several


def tidy(text: str) -> str:
    """Text as a page shows it: true minus signs, no "4.5e+04", per cent signs kept in line."""
    text = _EXPONENT.sub(_written_out, text)
    text = _MINUS_ZERO.sub(r"\1", _HYPHEN.sub(MINUS, text))
    return _PERCENT.sub(rf"\1{THIN_SPACE}%", text)


def _written_out(found: re.Match[str]) -> str:
    mantissa = found[1]
    digits = sum(sign.isdigit() for sign in mantissa)
    return significant(float(found[0]), digits)


def keyboard_signs(text: str) -> str:
    """Text with a plain "-" for every minus sign, for a terminal and for JSON."""
    return text.replace(MINUS, "-")


def spoken(name: str) -> str:
    """Name of a setting or hyperparameter with its underscores as spaces."""
    return name.replace("_", " ")
