"""Units that a report is written in, as its reader wants them."""

from __future__ import annotations

from dataclasses import dataclass

from hdprog.units import Dimension, find_unit

ANGLE_UNITS = ("arcmin", "arcsec", "deg", "mrad", "rad")
TORQUE_UNITS = ("Nm", "in·lbf", "ft·lbf")


@dataclass(frozen=True)
class ReportSettings:
    """Units of angles and torques in reports; a stiffness is torque over rad.

    Files keep their own units: Nm and arcmin in summary.json, Nm and rad in posterior.nc.
    """

    angle_unit: str = "arcmin"
    torque_unit: str = "Nm"


def angle_unit(text: str) -> str | None:
    """Name of a unit for angles in reports, however it is spelt; None for any other."""
    return _named(text, "angle", ANGLE_UNITS)


def torque_unit(text: str) -> str | None:
    """Name of a unit for torques in reports, however it is spelt; None for any other."""
    return _named(text, "torque", TORQUE_UNITS)


def _named(text: str, dimension: Dimension, known: tuple[str, ...]) -> str | None:
    unit = find_unit(text)
    if unit is None or unit.dimension != dimension or unit.name not in known:
        return None
    return unit.name
