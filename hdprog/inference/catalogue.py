"""Stiffness of strain wave gears by series, size and ratio, as makers' catalogues give it.

The numbers stand in priors/catalogue.toml with their sources.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from functools import cache
from typing import Any

from hdprog.errors import BadInputError
from hdprog.shipped import shipped

_MODEL = re.compile(r"\s*([a-z]+)[-_ ]?(\d+)[-_ ](\d+)(?P<type>[-_ ].*)?\s*", re.IGNORECASE)
_FEWEST_TORSION, _MOST_TORSION = 1e-4, 5e-2  # rad at T2; the catalogue's lie at 8e-4 to 4e-3


@dataclass(frozen=True)
class CatalogueNumbers:
    """Piecewise-linear stiffness of a gear: K1 up to T1, K2 to T2, K3 above.

    Attributes
    ----------
    T1, T2 : in Nm
    K1, K2, K3 : in Nm/rad
    rated_torque : in Nm, where it is known
    """

    T1: float
    T2: float
    K1: float
    K2: float
    K3: float
    rated_torque: float | None = None

    @property
    def table(self) -> dict[str, float]:
        """The numbers under the names of the [catalogue] table of a prior file."""
        table = {
            "T1_Nm": self.T1,
            "T2_Nm": self.T2,
            "K1_Nm_per_rad": self.K1,
            "K2_Nm_per_rad": self.K2,
            "K3_Nm_per_rad": self.K3,
        }
        if self.rated_torque is not None:
            table["rated_torque_Nm"] = self.rated_torque
        return table

    def torsion(self, torque: float) -> float:
        """Torsion angle in rad at a torque in Nm, zero or more."""
        first = min(torque, self.T1) / self.K1
        second = max(0.0, min(torque, self.T2) - self.T1) / self.K2
        return first + second + max(0.0, torque - self.T2) / self.K3

    def check(self, where: str) -> None:
        """Refuse numbers that no strain wave gear has, most often those in other units.

        Raises
        ------
        BadInputError
            which one, what was expected, and what to do
        """
        for name, value in self.table.items():
            if not 0 < value < float("inf"):
                raise BadInputError(
                    f"{name} = {value:g}", where, "a number above zero", f"Correct {name}."
                )
        if self.T1 >= self.T2:
            raise BadInputError(
                f"T1 = {self.T1:g} Nm and T2 = {self.T2:g} Nm",
                where,
                "T1 below T2, where the catalogue's curve first and last changes its slope",
                "Exchange them if they were swapped.",
            )
        if not self.K1 <= self.K2 <= self.K3:
            raise BadInputError(
                f"K1 = {self.K1:g}, K2 = {self.K2:g} and K3 = {self.K3:g} Nm/rad",
                where,
                "K1 at most K2 and K2 at most K3, as the gear stiffens while its teeth mesh",
                "Take the order of the columns from the catalogue; the model has no gear that "
                "softens under load.",
            )
        torsion = self.torsion(self.T2)
        if not _FEWEST_TORSION <= torsion <= _MOST_TORSION:
            raise BadInputError(
                f"a torsion of {torsion:.3g} rad at T2",
                where,
                f"{_FEWEST_TORSION:g} to {_MOST_TORSION:g} rad",
                "Give torques in Nm and stiffnesses in Nm/rad: catalogues print K in units of "
                "10⁴ Nm/rad, or in Nm/arcmin (1 Nm/arcmin is 3438 Nm/rad).",
            )


@dataclass(frozen=True)
class CatalogueGear:
    """One entry of the catalogue.

    Attributes
    ----------
    series : the series that it holds for; the first gives its name
    size : as in the model's name
    ratio, ratios : of the entry, and all that it holds for
    numbers : torques and stiffnesses
    source : in words
    """

    series: tuple[str, ...]
    size: int
    ratio: int
    ratios: tuple[int, ...]
    numbers: CatalogueNumbers
    source: str

    @property
    def name(self) -> str:
        """Name of its prior, e.g. ``csg-25-80``."""
        return f"{self.series[0]}-{self.size}-{self.ratio}".lower()

    @property
    def models(self) -> list[str]:
        """Names of the models that it holds for, e.g. ``CSF-25-100``."""
        return [f"{series}-{self.size}-{ratio}" for series in self.series for ratio in self.ratios]

    @property
    def words(self) -> str:
        """Series, size and ratios in words."""
        *most, last = map(str, self.ratios)
        ratios = f"{', '.join(most)} or {last}" if most else last
        return f"{', '.join(self.series)}, size {self.size}, ratio {ratios}"


@cache
def gears() -> tuple[CatalogueGear, ...]:
    """All entries of the catalogue, in its order."""
    content = tomllib.loads((shipped("priors") / "catalogue.toml").read_text("utf-8"))
    return tuple(_gear(entry, content) for entry in content["gears"])


def _gear(entry: dict[str, Any], content: dict[str, Any]) -> CatalogueGear:
    letters, _, remark = str(entry["source"]).partition(" (")
    named = " and ".join(content["sources"][letter] for letter in letters.split(" + "))
    return CatalogueGear(
        series=tuple(entry["series"].split("/")),
        size=entry["size"],
        ratio=entry["ratio"],
        ratios=tuple(content["ratios"][str(entry["ratio"])]),
        numbers=CatalogueNumbers(**{key: float(entry[key]) for key in _NUMBERS}),
        source=named + (f" ({remark}" if remark else ""),
    )


_NUMBERS = ("T1", "T2", "K1", "K2", "K3")


def model_key(model: str, *, types: bool = True) -> str | None:
    """Series, size and ratio of a model's name as ``csf-25-80``; None where it is no such name.

    Parameters
    ----------
    model : e.g. "CSF-25-80" or "csg-25-100-2UH", upper or lower case
    types : whether a type such as "-2UH" may follow the ratio
    """
    match = _MODEL.fullmatch(model)
    if match is None or (match["type"] and not types):
        return None
    return f"{match[1]}-{int(match[2])}-{int(match[3])}".lower()


def ratio_doubt(model: str | None, ratio: float | None) -> str | None:
    """Say where a model's name has another ratio than the one declared; None where all is well.

    Parameters
    ----------
    model, ratio : as declared; a ratio one above the model's is that of its circular spline
    """
    key = None if model is None else model_key(model)
    if key is None or ratio is None:
        return None
    named = int(key.rpartition("-")[2])
    if ratio in (named, named + 1):
        return None
    return (
        f"The model {model} has the ratio {named}, and ratio = {ratio:g} is declared: catalogue "
        "figures, and the prior where drive.toml names no other, are those of the model. Correct "
        "the one that is wrong in drive.toml."
    )


def times_expected(model: str | None, stiffness: float, span: float, sides: str) -> float | None:
    """Secant stiffness of a record over its model's in the catalogue; None for unknown models.

    Parameters
    ----------
    model : as declared
    stiffness : in Nm/rad, of the whole record
    span : from its smallest torque to its largest, in Nm
    sides : "one-sided" or "two-sided", as its quality says
    """
    gear = None if model is None else find_gear(model)
    if gear is None:
        return None
    peak = span / (2.0 if sides == "two-sided" else 1.0)
    return stiffness * gear.numbers.torsion(peak) / peak


def find_gear(model: str, *, types: bool = True) -> CatalogueGear | None:
    """The entry of a model's name, or None where the catalogue has none; see `model_key`."""
    key = model_key(model, types=types)
    for gear in gears():
        if key in [known.lower() for known in gear.models]:
            return gear
    return None


def look_up(series: str, size: int, ratio: int) -> CatalogueGear:
    """The entry of a series, size and ratio.

    Raises
    ------
    BadInputError
        saying what the catalogue holds instead
    """
    known = gears()
    gear = find_gear(f"{series}-{size}-{ratio}", types=False)
    if gear is not None:
        return gear
    wanted = series.upper()
    of_series = [gear for gear in known if wanted in gear.series]
    of_size = [gear for gear in of_series if gear.size == size]
    if not of_series:
        expected = "one of " + ", ".join(dict.fromkeys(s for gear in known for s in gear.series))
    elif not of_size:
        sizes = sorted({gear.size for gear in of_series})
        expected = f"of {wanted} one of the sizes " + ", ".join(map(str, sizes))
    else:
        ratios = sorted({ratio for gear in of_size for ratio in gear.ratios})
        expected = f"of {wanted}-{size} one of the ratios " + ", ".join(map(str, ratios))
    raise BadInputError(
        f"no {wanted}-{size}-{ratio}",
        "the catalogue, priors/catalogue.toml",
        expected,
        "Take one of these, or give the numbers of the drive's own data sheet: "
        "hdprog prior from-catalogue --K1 … --K2 … --K3 … --T1 … --T2 …",
    )
