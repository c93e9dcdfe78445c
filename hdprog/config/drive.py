"""What is declared about one drive: frozen settings, as the rest of hdprog uses them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hdprog.config.limits import Limit, refuse_contradictions, require_rated_torque
from hdprog.config.report_settings import ReportSettings
from hdprog.config.rules import (
    ColumnsTable,
    Hours,
    Positive,
    Risk,
    Text,
    ToothAngle,
    Torque,
    Values,
    check_fields,
    check_table,
)
from hdprog.errors import UsageError, shown_argument

DEFAULT_ALPHA = math.radians(30.0)


@dataclass(frozen=True)
class NoiseResolution:
    """Resolution of the rig's torque [Nm] and angle [rad]; None is to be inferred."""

    torque_Nm: Torque | None = None
    angle_rad: Positive | None = None

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class ForecastSettings:
    """How far and at which risk the forecast looks, in service hours counted from zero."""

    horizon_hours: Hours = 20_000.0
    acceptable_risk: Risk = 0.05
    next_shutdown_hours: Hours | None = None

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class Drive:
    """What is declared about one drive. Angles in rad, torques in Nm.

    `alpha` is the gear-tooth angle, never fitted; `alpha_declared` is False where it is the
    default of 30 degrees. `prior` is a name in priors/ or a path. `columns` maps a role (torque,
    angle, time, temperature, output_angle) to ``HEADER:unit`` of the drive's logs; `select` maps a
    column to the values of the rows to keep. `report` says how a report is written. `source` is
    the file that all this was read from.

    Raises
    ------
    BadInputError
        for a value that drive.toml could not have either, such as a tooth angle in degrees
    """

    id: Text = "drive"
    model: Text | None = None
    ratio: Positive | None = None
    alpha: ToothAngle = DEFAULT_ALPHA
    alpha_declared: bool = False
    rated_torque: Torque | None = None
    reference_torque: Torque | None = None
    noise: NoiseResolution = NoiseResolution()
    prior: Text | None = None
    limits: tuple[Limit, ...] = ()
    forecast: ForecastSettings = ForecastSettings()
    columns: Mapping[str, str] = field(default_factory=dict)
    select: Mapping[Text, Values] = field(default_factory=dict)
    report: ReportSettings = field(default_factory=ReportSettings)
    source: Path | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        check_table(self, "columns", ColumnsTable)
        for limit in self.limits:
            require_rated_torque(limit.quantity, self.rated_torque, "Drive, limits")
        refuse_contradictions(self.limits, "Drive, limits")

    @classmethod
    def default(cls) -> Drive:
        """Return a drive of which nothing is declared."""
        return cls()


def require_drive(given: object) -> Drive | None:
    """A drive that was read, or None for none.

    Raises
    ------
    UsageError
        for the path of a drive's file, or anything else
    """
    if given is None or isinstance(given, Drive):
        return given
    raise UsageError(
        f"drive: found {shown_argument(given)}, expected a drive that was read. Give what "
        "hdprog.read_drive makes of the file."
    )
