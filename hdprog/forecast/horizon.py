"""The horizon of a drive's forecasts, told by its file."""

from __future__ import annotations

from collections.abc import Sequence

from hdprog.config import Drive
from hdprog.data.drive_folder import DriveTest
from hdprog.errors import BadInputError
from hdprog.forecast.crossing import require_horizon_ahead


def require_horizon(drive: Drive, tests: Sequence[DriveTest]) -> None:
    """Refuse a horizon that is not after the last test; of many drives, the file is named.

    Raises
    ------
    BadInputError
        so it is
    """
    try:
        require_horizon_ahead(tests[-1].service_hours, drive.forecast.horizon_hours)
    except BadInputError as error:
        where = f"{drive.source or 'drive.toml'}, [forecast] horizon_hours"
        raise BadInputError(error.found, where, error.expected, error.advice) from error
