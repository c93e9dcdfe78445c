"""What to call a drive, above all one of which nothing was declared."""

from __future__ import annotations

from hdprog.config import Drive
from hdprog.results import DriveResult


def is_declared(drive: Drive) -> bool:
    """Whether the drive has a name of its own, not the one that stands in for none."""
    return drive.source is not None or drive.id != Drive.default().id


def drive_name(result: DriveResult) -> str:
    """Name of the drive; of one that is not declared the name of its file, without its ending."""
    if is_declared(result.drive) or len(result.tests) != 1:
        return result.drive.id
    return result.tests[0].test_id
