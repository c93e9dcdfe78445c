"""What is declared about one drive: frozen settings, as the rest of hdprog uses them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from hdprog.config.report_settings import ReportSettings
from hdprog.config.rules import Hours, Positive, Risk, Text, ToothAngle, Torque, check_fields

STIFFNESSES_AT_TORQUE = ("local_stiffness_Nm_per_rad", "secant_stiffness_Nm_per_rad")
CATALOGUE_STIFFNESSES = ("K1_Nm_per_rad", "K2_Nm_per_rad", "K3_Nm_per_rad")
"""Between the torques of makers' catalogues: 0 to T1, to T2, and beyond."""
QUANTITIES = (
    "hysteresis_width_arcmin",
    "hysteresis_loss_J",
    "lost_motion_arcmin",
    "preload_Nm",
    *STIFFNESSES_AT_TORQUE,
    *CATALOGUE_STIFFNESSES,
)
"""Every figure of merit that a limit may be set on."""

DEFAULT_ALPHA = math.radians(30.0)


@dataclass(frozen=True)
class Limit:
    """A figure of merit and the threshold that it must not cross.

    `threshold` is in the unit that the quantity's name ends in; `direction` is the side that is
    past the limit; `at_torque_Nm` is set for stiffnesses at a torque and None for all others.
    """

    quantity: str
    threshold: Positive
    direction: Literal["above", "below"]
    at_torque_Nm: Torque | None = None

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def key(self) -> str:
        """Key of the figure in summaries, e.g. ``secant_stiffness_Nm_per_rad@14Nm``."""
        if self.at_torque_Nm is None:
            return self.quantity
        return f"{self.quantity}@{self.at_torque_Nm:g}Nm"


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
    select: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    report: ReportSettings = field(default_factory=ReportSettings)
    source: Path | None = None

    def __post_init__(self) -> None:
        check_fields(self)

    @classmethod
    def default(cls) -> Drive:
        """Return a drive of which nothing is declared."""
        return cls()
