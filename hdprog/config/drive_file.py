"""Reading a drive's file (drive.toml): Pydantic at the edge, words for what is wrong."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from hdprog.config.as_written import as_written
from hdprog.config.drive import (
    DEFAULT_ALPHA,
    Drive,
    ForecastSettings,
    NoiseResolution,
)
from hdprog.config.limits import (
    Limit,
    nearest,
    refuse_contradictions,
    require_quantity,
    require_rated_torque,
)
from hdprog.config.report_settings import ReportSettings, report_settings
from hdprog.config.rules import (
    STRICT,
    ColumnsTable,
    Hours,
    Positive,
    Risk,
    Text,
    ToothAngleDegrees,
    Torque,
    Values,
    expected_words,
)
from hdprog.errors import BadInputError

__all__ = ["drive_from_mapping", "read_drive"]


class _Section(BaseModel):
    model_config = STRICT


class _DriveSection(_Section):
    id: Text
    model: Text | None = None
    ratio: Positive | None = None
    alpha_deg: ToothAngleDegrees | None = None
    rated_torque_Nm: Torque | None = None
    reference_torque_Nm: Torque | None = None


class _NoiseSection(_Section):
    torque_resolution_Nm: Torque | None = None
    angle_resolution_rad: Positive | None = None


class _PriorSection(_Section):
    file: Text | None = None


class _LimitSection(_Section):
    quantity: str
    at_torque_Nm: Torque | None = None
    above: Positive | None = None
    below: Positive | None = None


class _ForecastSection(_Section):
    horizon_hours: Hours = ForecastSettings.horizon_hours
    acceptable_risk: Risk = ForecastSettings.acceptable_risk
    next_shutdown_hours: Hours | None = ForecastSettings.next_shutdown_hours


class _ReportSection(_Section):
    angle_unit: Text = ReportSettings.angle_unit
    torque_unit: Text = ReportSettings.torque_unit


class _DriveFile(_Section):
    drive: _DriveSection
    noise: _NoiseSection = _NoiseSection()
    prior: _PriorSection = _PriorSection()
    limits: list[_LimitSection] = []
    forecast: _ForecastSection = _ForecastSection()
    columns: ColumnsTable = ColumnsTable()
    select: dict[Text, Values] = {}
    report: _ReportSection = _ReportSection()


_SECTIONS: dict[str, type[BaseModel]] = {
    "drive": _DriveSection,
    "noise": _NoiseSection,
    "prior": _PriorSection,
    "limits": _LimitSection,
    "forecast": _ForecastSection,
    "columns": ColumnsTable,
    "report": _ReportSection,
}


def read_drive(path: str | Path) -> Drive:
    """Read a drive's file.

    Parameters
    ----------
    path : str or Path
        A drive.toml, or the folder that holds one.

    Raises
    ------
    BadInputError
        No such file, no valid TOML, a key that is not known, or a value that cannot be.
    """
    path = Path(path)
    if path.is_dir():
        path = path / "drive.toml"
    try:
        text = path.read_text(encoding="utf-8-sig")
        content = tomllib.loads(text)
    except OSError as error:
        raise BadInputError(
            f"no readable file ({error.strerror})",
            str(path),
            "the drive's file, drive.toml",
            "Give the path of a drive.toml or of the folder that holds it.",
        ) from error
    except (ValueError, RecursionError) as error:  # also of thousands of digits or brackets
        raise BadInputError(
            f"text that is not valid TOML ({error})",
            str(path),
            "a drive's file in TOML, saved as UTF-8",
            'Correct that place; text values need quotation marks: id = "cell3-axis2".',
        ) from error
    return drive_from_mapping(content, path)


def drive_from_mapping(mapping: Mapping[str, Any], source: Path | None = None) -> Drive:
    """Validate the content of a drive's file and freeze it.

    Parameters
    ----------
    mapping : mapping
        The content of a drive.toml, as tomllib or a JSON reader gives it.
    source : Path or None
        Where it came from, for messages and for relative paths in it.

    Raises
    ------
    BadInputError
        A key that is not known, or a value that cannot be.
    """
    where = str(source) if source is not None else "drive settings"
    try:
        # Strict mode takes a list for a list; a plain dict is what Pydantic checks best.
        content = _DriveFile.model_validate(dict(mapping))
    except ValidationError as error:
        raise _in_words(error, where) from error
    rated = content.drive.rated_torque_Nm
    limits = tuple(
        _limit(section, rated, f"{where}, [[limits]] number {number}")
        for number, section in enumerate(content.limits, start=1)
    )
    refuse_contradictions(limits, f"{where}, [[limits]]")
    alpha_deg = content.drive.alpha_deg
    return Drive(
        id=content.drive.id.strip(),
        model=content.drive.model,
        ratio=content.drive.ratio,
        alpha=DEFAULT_ALPHA if alpha_deg is None else math.radians(alpha_deg),
        alpha_declared=alpha_deg is not None,
        rated_torque=rated,
        reference_torque=content.drive.reference_torque_Nm,
        noise=NoiseResolution(
            content.noise.torque_resolution_Nm, content.noise.angle_resolution_rad
        ),
        prior=content.prior.file,
        limits=limits,
        forecast=ForecastSettings(**content.forecast.model_dump()),
        columns=content.columns.model_dump(exclude_none=True),
        select=dict(content.select),
        report=report_settings(**content.report.model_dump(), where=f"{where}, [report]"),
        source=source,
    )


def _limit(section: _LimitSection, rated: float | None, where: str) -> Limit:
    """Check what the parts of one limit mean together."""
    quantity, at = section.quantity, section.at_torque_Nm
    require_quantity(quantity, at, where)
    require_rated_torque(quantity, rated, where)
    if section.above is not None and section.below is None:
        return Limit(quantity, section.above, "above", at)
    if section.below is not None and section.above is None:
        return Limit(quantity, section.below, "below", at)
    raise BadInputError(
        "neither above nor below" if section.above is None else "both above and below",
        where,
        "exactly one of them",
        "Write above = 2.0 where high values are bad, below = 0.3 where low ones are; two limits "
        "are two [[limits]] entries.",
    )


# What others call the two sides of a limit; none of it is like their names here.
_SIDES = {
    "above": ("max", "maximum", "upper", "highest", "not_above"),
    "below": ("min", "minimum", "lower", "lowest", "not_below"),
}


def _meant(key: str, known: tuple[str, ...]) -> str:
    """Propose a key for one that is not known."""
    word = key.lower()
    for side, others in _SIDES.items():
        if side in known and word.startswith(others):
            return f"Did you mean {side}? It names the side that is past the limit."
    return nearest(key, known)


_ADVICE = {"alpha_deg": "Correct alpha_deg: the tooth angle in degrees, such as 30.0."}


def _in_words(error: ValidationError, where: str) -> BadInputError:
    """Turn what Pydantic refused first into the words of this project."""
    # A key that is not known comes first: it is often the one that another one misses.
    first = min(error.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
    path = [str(part) for part in first["loc"]]
    key, place = path[-1], where
    section = _SECTIONS.get(path[0]) if len(path) > 1 else _DriveFile
    if path[0] == "limits" and len(path) > 1:
        place += f", [[limits]] number {int(path[1]) + 1}"
        key = path[2] if len(path) > 2 else "the entry"
    elif len(path) > 1:
        place += f", [{path[0]}]"
        if path[0] == "select":
            key = path[1]
    if first["type"] == "extra_forbidden":
        known = tuple(section.model_fields) if section is not None else ()
        return BadInputError(
            f"the key {key}, which is not known here",
            place,
            "only " + ", ".join(known),
            _meant(key, known) or "Remove it or correct its name.",
        )
    if first["type"] == "missing" and len(path) == 1:
        needed = (n for n, field in _SECTIONS[key].model_fields.items() if field.is_required())
        return BadInputError(
            f"no [{key}] table",
            place,
            f"[{key}] with {' and '.join(needed)}",
            'Begin with a line [drive] and below it one such as id = "axis-3".',
        )
    if first["type"] == "missing":
        return BadInputError(f"no {key}", place, f"{key} to be given", f"Add {key}.")
    bounds = first.get("ctx", {})
    kind = "tuple_type" if key != path[-1] and path[0] == "select" else first["type"]
    expected = expected_words(kind, bounds)
    advice = _ADVICE.get(key, f"Correct {key}.")
    found = f"{key} = {as_written(first['input'])}"
    return BadInputError(found, place, expected or first["msg"], advice)
