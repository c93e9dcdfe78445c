"""The form of a drive: the content of its drive.toml as fields, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hdprog.errors import BadInputError

LIMIT_ROWS = 6
_NUMBERS = ("ratio", "alpha_deg", "rated_torque_Nm", "reference_torque_Nm")
_FORECAST = ("horizon_hours", "acceptable_risk", "next_shutdown_hours")
_NOISE = ("torque_resolution_Nm", "angle_resolution_rad")
_SECTIONS = ("drive", "forecast", "noise", "prior", "columns", "limits")
_COLUMNS = ("torque", "angle", "time", "temperature", "output_angle")


def fields_of(content: Mapping[str, Any]) -> dict[str, str]:
    """Give the fields of a drive's form.

    Parameters
    ----------
    content : of a drive.toml
    """
    drive = content.get("drive", {})
    fields = {name: _text(drive.get(name)) for name in ("id", "model", *_NUMBERS)}
    fields["prior"] = _text(content.get("prior", {}).get("file"))
    for section, names in (("forecast", _FORECAST), ("noise", _NOISE), ("columns", _COLUMNS)):
        found = content.get(section, {})
        fields |= {f"{section}_{name}": _text(found.get(name)) for name in names}
    for number, limit in enumerate(content.get("limits", [])):
        direction = "above" if "above" in limit else "below"
        fields |= {
            f"limit{number}_quantity": limit["quantity"],
            f"limit{number}_direction": direction,
            f"limit{number}_value": _text(limit[direction]),
            f"limit{number}_torque": _text(limit.get("at_torque_Nm")),
        }
    return fields


def content_of_form(
    fields: Mapping[str, str], kept: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Give the content of a drive.toml that a form says.

    Parameters
    ----------
    fields : of the form
    kept : earlier content; what the form has no fields for stays, such as a selection of rows

    Raises
    ------
    BadInputError
        for text where a number belongs
    """
    content = {name: value for name, value in (kept or {}).items() if name not in _SECTIONS}
    drive: dict[str, Any] = {"id": fields.get("id", "").strip()}
    if model := fields.get("model", "").strip():
        drive["model"] = model
    content["drive"] = drive | _numbers(fields, "", _NUMBERS)
    for section, names in (("forecast", _FORECAST), ("noise", _NOISE)):
        if found := _numbers(fields, f"{section}_", names):
            content[section] = found
    if prior := fields.get("prior", "").strip():
        content["prior"] = {"file": prior}
    columns = {name: fields.get(f"columns_{name}", "").strip() for name in _COLUMNS}
    if columns := {name: text for name, text in columns.items() if text}:
        content["columns"] = columns
    limits = [_limit(fields, number) for number in range(LIMIT_ROWS)]
    content["limits"] = [limit for limit in limits if limit]
    return content


def _limit(fields: Mapping[str, str], number: int) -> dict[str, Any]:
    prefix = f"limit{number}_"
    quantity = fields.get(f"{prefix}quantity", "")
    if not quantity:
        return {}
    value = _number(fields, f"{prefix}value", f"limit {number + 1}")
    if value is None:
        raise BadInputError(
            "no value",
            f"limit {number + 1}",
            "a number that the figure must not cross",
            "Fill it in, or choose no figure in this row.",
        )
    torque = _number(fields, f"{prefix}torque", f"torque of limit {number + 1}")
    limit: dict[str, Any] = {"quantity": quantity}
    if torque is not None:
        limit["at_torque_Nm"] = torque
    direction = "above" if fields.get(f"{prefix}direction") == "above" else "below"
    return limit | {direction: value}


def _numbers(fields: Mapping[str, str], prefix: str, names: tuple[str, ...]) -> dict[str, float]:
    found = {name: _number(fields, prefix + name, name) for name in names}
    return {name: value for name, value in found.items() if value is not None}


def _number(fields: Mapping[str, str], name: str, called: str) -> float | None:
    text = fields.get(name, "").strip()
    if not text:
        return None
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise BadInputError(
            f"the text {text[:40]!r}", called, "a number, such as 63 or 9.77e-6", "Correct it."
        ) from None


def _text(value: object) -> str:
    if value is None:
        return ""
    return f"{value:g}" if isinstance(value, float) else str(value)
