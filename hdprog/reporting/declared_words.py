"""What is declared of a drive and lies where its tests or its forecast do not reach, in words."""

from __future__ import annotations

import numpy as np

from hdprog.config import Drive
from hdprog.inference.catalogue import ratio_doubt
from hdprog.physics.figures import LOST_MOTION_SHARE
from hdprog.reporting import outlook
from hdprog.reporting.far_limits import far_limits
from hdprog.reporting.limits_left_behind import limits_left_behind
from hdprog.reporting.rounding import hours
from hdprog.reporting.words import capital, quantity, torque_words
from hdprog.results import DriveResult

_REACHED = 1.05  # times the largest torque of the tests: up to there nothing is said


def declared_words(result: DriveResult) -> list[str]:
    """Sentences on limits far off, another ratio than the model's, too high torques, shutdowns."""
    ratio = ratio_doubt(result.drive.model, result.drive.ratio)
    far = far_limits(result, result.drive.limits)
    said = [*far, *limits_left_behind(result), *([ratio] if ratio else [])]
    return [*said, *_beyond(result), *_shutdown(result)]


def _beyond(result: DriveResult) -> list[str]:
    largest = max(float(np.abs(test.loop.torque).max()) for test in result.tests)
    return limits_beyond(result.drive, largest)


def limits_beyond(drive: Drive, largest: float) -> list[str]:
    """Sentences on limits that are read at more torque than the largest of the records [Nm]."""
    said = []
    for limit in drive.limits:
        at, place = limit.at_torque_Nm, ""
        advice = "set the limit at a torque that the tests reach"
        if limit.quantity == "lost_motion_arcmin" and drive.rated_torque is not None:
            at = LOST_MOTION_SHARE * drive.rated_torque
            place = f" and is read at ±{torque_words(at)}"
            advice = "check that its torque is the output's, in the unit that is given"
        if at is not None and at > _REACHED * largest:
            said.append(
                f"{capital(quantity(limit.key).name)} has a limit{place}, and the tests reach "
                f"{torque_words(largest)} only: beyond that the model is extrapolated. Load the "
                f"drive that far, or {advice}."
            )
    return list(dict.fromkeys(said))


def _shutdown(result: DriveResult) -> list[str]:
    settings, main = result.drive.forecast, outlook.overall(result.forecasts)
    at = settings.next_shutdown_hours
    if at is None or main is None:
        return []
    if at <= main.now_hours:
        return [
            f"The next shutdown is given as {hours(at)}, which is not after the last test at "
            f"{hours(main.now_hours)}: no risk is stated by it. Set next_shutdown_hours anew."
        ]
    if at > settings.horizon_hours:
        return [
            f"The next shutdown is given as {hours(at)}, past the horizon of "
            f"{hours(settings.horizon_hours)}: the risk by it looks farther ahead than the "
            "forecast was asked to. Raise horizon_hours, or plan a shutdown before it."
        ]
    return []
