"""The drive's file (drive.toml): what is known and declared about one drive, and its limits."""

from hdprog.config.drive import Drive, ForecastSettings, NoiseResolution, require_drive
from hdprog.config.drive_file import drive_from_mapping, read_drive
from hdprog.config.limits import QUANTITIES, Limit
from hdprog.config.report_settings import ReportSettings

__all__ = [
    "QUANTITIES",
    "Drive",
    "ForecastSettings",
    "Limit",
    "NoiseResolution",
    "ReportSettings",
    "drive_from_mapping",
    "read_drive",
    "require_drive",
]
