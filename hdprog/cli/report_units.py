"""Units of a report as the command line asks for them, before those of drive.toml."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from hdprog.errors import BadInputError, UsageError

if TYPE_CHECKING:
    from hdprog.config import ReportSettings

Change = Callable[["ReportSettings"], "ReportSettings"]


def wanted_units(angle: str | None, torque: str | None) -> Change:
    """Give what changes a drive's own settings; what was not asked for stays.

    Raises
    ------
    UsageError
        for a unit that no report is written in
    """
    from hdprog.config.report_settings import ReportSettings, report_settings

    usual = ReportSettings()
    try:
        asked = report_settings(angle or usual.angle_unit, torque or usual.torque_unit, "report")
    except BadInputError as error:
        key, _, value = error.found.partition(" = ")
        option = f"--{key.replace('_', '-')}"
        raise UsageError(f"{option}: found {value}, expected {error.expected}") from error

    def change(own: ReportSettings) -> ReportSettings:
        if angle:
            own = replace(own, angle_unit=asked.angle_unit)
        return replace(own, torque_unit=asked.torque_unit) if torque else own

    return change
