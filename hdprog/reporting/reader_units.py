"""Numbers in the units that the reader of a report wants.

Inside hdprog angles are rad (figures of merit: arcmin) and torques Nm; only what a reader sees is
converted, where it is put into words, a table or a picture.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from hdprog.config import ReportSettings
from hdprog.units import find_unit

_DEFAULT = ReportSettings()
_WANTED: ContextVar[ReportSettings] = ContextVar("_WANTED", default=_DEFAULT)
_TORQUE = re.compile(r"\bNm\b")


@dataclass(frozen=True)
class Shown:
    """How numbers of a unit are shown.

    Attributes
    ----------
    factor : a number in the unit inside times this is the number shown
    unit : the unit shown
    """

    factor: float
    unit: str


@contextmanager
def shown_in(settings: ReportSettings) -> Iterator[None]:
    """Show all numbers in these units for as long as the block runs."""
    token = _WANTED.set(settings)
    try:
        yield
    finally:
        _WANTED.reset(token)


def shown(unit: str) -> Shown:
    """How numbers of a unit inside hdprog, such as "arcmin" or "Nm/rad", are shown.

    Angles by themselves and torques are converted; everything else stays as it is, "rad" in a
    stiffness included.
    """
    wanted = _WANTED.get()
    if unit == "arcmin":
        return Shown(_in_si("arcmin") / _in_si(wanted.angle_unit), wanted.angle_unit)
    if wanted.torque_unit == _DEFAULT.torque_unit or not _TORQUE.search(unit):
        return Shown(1.0, unit)
    over, _, under = unit.partition("/")
    factor = 1.0
    if _TORQUE.search(over):
        factor /= _in_si(wanted.torque_unit)
    if _TORQUE.search(under):
        factor *= _in_si(wanted.torque_unit)
    return Shown(factor, _TORQUE.sub(wanted.torque_unit, unit))


def loop_angle() -> Shown:
    """How the angle of a loop, in rad inside, is shown."""
    wanted = _WANTED.get().angle_unit
    return Shown(1.0 / _in_si(wanted), wanted)


def loop_torque() -> Shown:
    """How torque, in Nm inside, is shown."""
    return shown("Nm")


def _in_si(name: str) -> float:
    unit = find_unit(name)
    if unit is None:
        raise ValueError(f"{name} is no unit that hdprog knows")
    return unit.factor
