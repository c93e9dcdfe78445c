"""True crossings of a simulated drive, as the truth.json beside its tests tells them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hdprog.config import Drive, Limit
from hdprog.errors import BadInputError


@dataclass(frozen=True)
class Truth:
    """True crossings of a simulated drive.

    Attributes
    ----------
    crossings : service hours by limit, infinite where it is not crossed by then
    known_until : service hours up to which they are known
    """

    crossings: Mapping[Limit, float]
    known_until: float


def read_truth(path: Path, drive: Drive) -> Truth | None:
    """True crossings of a simulated drive's limits; None without the file.

    Parameters
    ----------
    path : truth.json, with `crossing_hours` by the limit's key (which tells nothing of two limits
        on one side of a figure), or `limits` of which each has its own; null is a limit that is not
        crossed by the file's `horizon_hours`
    drive : its limits and horizon

    Raises
    ------
    BadInputError
        for a file that holds neither, or no numbers where they should be
    """
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_text("utf-8"))
        until = float(content.get("horizon_hours", drive.forecast.horizon_hours))
        crossings = {limit: _true_hours(limit, content, drive) for limit in drive.limits}
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise BadInputError(
            "no crossing hours that can be read",
            str(path),
            '"crossing_hours": {"lost_motion_arcmin": 1315.0} with a number or null for each limit',
            "Correct the file; or remove it, and the later tests tell what came.",
        ) from error
    known = {limit: hours for limit, hours in crossings.items() if hours is not None}
    return Truth(known, until) if known else None


def _true_hours(limit: Limit, content: Mapping[str, Any], drive: Drive) -> float | None:
    """Hour of a limit's true crossing, infinite if never; None where the file is silent."""
    for entry in content.get("limits", ()):
        at = entry.get("at_torque_Nm")
        named = (entry["quantity"], entry["direction"], None if at is None else float(at))
        if named == (limit.quantity, limit.direction, limit.at_torque_Nm) and math.isclose(
            float(entry["limit"]), limit.threshold
        ):
            return _hours(entry["crossing_hours"])
    by_key = content.get("crossing_hours", {})
    sides = [(one.key, one.direction) for one in drive.limits]
    alone = sides.count((limit.key, limit.direction)) == 1
    if "limits" not in content and alone and limit.key in by_key:
        return _hours(by_key[limit.key])
    return None


def _hours(value: Any) -> float:
    return math.inf if value is None else float(value)
