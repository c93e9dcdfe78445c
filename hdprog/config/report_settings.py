"""Units that a report is written in, as its reader wants them."""

from __future__ import annotations

from dataclasses import dataclass

from hdprog.errors import BadInputError
from hdprog.units import find_unit

ANGLE_UNITS = ("arcmin", "arcsec", "deg", "mrad", "rad")
TORQUE_UNITS = ("Nm", "in·lbf", "ft·lbf")


@dataclass(frozen=True)
class ReportSettings:
    """Units of angles and torques in reports; a stiffness is torque over rad.

    Files keep their own units: Nm and arcmin in summary.json, Nm and rad in posterior.nc.

    Raises
    ------
    BadInputError
        for a unit that no report is written in
    """

    angle_unit: str = "arcmin"
    torque_unit: str = "Nm"

    def __post_init__(self) -> None:
        known = {"angle_unit": ANGLE_UNITS, "torque_unit": TORQUE_UNITS}
        for key, units in known.items():
            named = _named(key, getattr(self, key), units, "ReportSettings")
            object.__setattr__(self, key, named)


def report_settings(angle_unit: str, torque_unit: str, where: str) -> ReportSettings:
    """Settings from units however they are spelt ("in-lbf", "lbf in").

    Parameters
    ----------
    angle_unit, torque_unit : as written
    where : for messages

    Raises
    ------
    BadInputError
        for what is no such unit, or one that no report is written in
    """
    return ReportSettings(
        angle_unit=_named("angle_unit", angle_unit, ANGLE_UNITS, where),
        torque_unit=_named("torque_unit", torque_unit, TORQUE_UNITS, where),
    )


def _named(key: str, text: str, known: tuple[str, ...], where: str) -> str:
    unit = find_unit(text)
    if unit is None or unit.name not in known:
        raise BadInputError(
            f'{key} = "{text}"', where, "one of " + ", ".join(known), "Choose one of these."
        )
    return unit.name
