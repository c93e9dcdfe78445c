"""The form of a drive: the content of its drive.toml as fields, and back."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from hdprog.errors import BadInputError
from hdprog.web.numbers import number_of

_LIMIT_ROWS, _FIRST_ROWS = 6, 3  # those beyond the first unfold
_LIMIT_FIELD = re.compile(r"limit(0|[1-9][0-9]{0,2})_quantity")
_NUMBERS = ("ratio", "alpha_deg", "rated_torque_Nm", "reference_torque_Nm")
_FORECAST = ("horizon_hours", "acceptable_risk", "next_shutdown_hours")
_NOISE = ("torque_resolution_Nm", "angle_resolution_rad")
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
        fields |= _limit_fields(number, limit)
    return fields


def context_of(fields: Mapping[str, str]) -> dict[str, Any]:
    """Give what the form's template is filled with: a row for every limit, and some more."""
    numbers = _limit_numbers(fields)  # one emptied stays in sight, or it would seem not sent
    return {
        "fields": fields,
        "limit_rows": max(_LIMIT_ROWS, 1 + max(numbers, default=0)),
        "more_limits": any(fields[f"limit{one}_quantity"] for one in numbers[_FIRST_ROWS:]),
        "first_rows": _FIRST_ROWS,
    }


def content_of_form(
    fields: Mapping[str, str], kept: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Give the content of a drive.toml that a form says.

    Parameters
    ----------
    fields : of the form
    kept : earlier content; what the form has no fields for stays, such as a selection of rows, and
        so does what its fields show as they did

    Raises
    ------
    BadInputError
        for text where a number belongs
    """
    before = dict(kept or {})
    form = _Form(fields, before)
    drive = form.section("drive", text=("id", "model"), numbers=_NUMBERS)
    content = before | {
        "drive": {"id": ""} | drive,
        "forecast": form.section("forecast", "forecast_", numbers=_FORECAST),
        "noise": form.section("noise", "noise_", numbers=_NOISE),
        "columns": form.section("columns", "columns_", text=_COLUMNS),
        "limits": form.limits(),
    }
    prior = form.value("prior", before.get("prior", {}), "file")
    content["prior"] = {} if prior is _NOTHING else {"file": prior}
    # A section without a word in it is left out, unless it was there like that.
    return {
        name: value
        for name, value in content.items()
        if value or name == "limits" or before.get(name) == value
    }


_NOTHING = object()


class _Form:
    """The fields of a form beside what was declared before.

    A field that shows what it showed before, or that is not there, leaves what was declared: an
    empty text among the columns says that a column is left out, and shows as no text at all.
    """

    def __init__(self, fields: Mapping[str, str], before: Mapping[str, Any]) -> None:
        self.fields, self.before, self.shown = fields, before, fields_of(before)

    def section(
        self,
        name: str,
        prefix: str = "",
        *,
        text: tuple[str, ...] = (),
        numbers: tuple[str, ...] = (),
    ) -> dict[str, Any]:
        """Give a section of a drive.toml."""
        before = self.before.get(name, {})
        found = {key: self.value(prefix + key, before, key) for key in text}
        found |= {key: self.value(prefix + key, before, key, number=True) for key in numbers}
        return {key: value for key, value in found.items() if value is not _NOTHING}

    def value(
        self, field: str, before: Mapping[str, Any], key: str, *, number: bool = False
    ) -> object:
        """Give the value of a key, `_NOTHING` where the form says none."""
        text = self.fields.get(field)
        if text is None or text.strip() == self.shown[field].strip():
            return before.get(key, _NOTHING)
        found = _number(self.fields, field, key) if number else text.strip() or None
        return _NOTHING if found is None else found

    def limits(self) -> list[dict[str, Any]]:
        """Give the limits; those that the form has no row for stay."""
        before = self.before.get("limits", [])
        said = {number: _limit(self.fields, number) for number in _limit_numbers(self.fields)}
        found = dict(enumerate(before)) | said
        return [found[number] for number in sorted(found) if found[number]]


def _limit_numbers(fields: Mapping[str, str]) -> list[int]:
    """Give the numbers of the rows of limits, in order."""
    found = [_LIMIT_FIELD.fullmatch(name) for name in fields]
    return sorted(int(match[1]) for match in found if match)


def _limit_fields(number: int, limit: Mapping[str, Any]) -> dict[str, str]:
    direction = "above" if "above" in limit else "below"
    return {
        f"limit{number}_quantity": limit["quantity"],
        f"limit{number}_direction": direction,
        f"limit{number}_value": _text(limit[direction]),
        f"limit{number}_torque": _text(limit.get("at_torque_Nm")),
    }


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


def _number(fields: Mapping[str, str], name: str, called: str) -> float | None:
    text = fields.get(name, "").strip()
    if not text:
        return None
    try:
        return number_of(text, called)
    except ValueError:
        raise BadInputError(
            f"the text {text[:40]!r}", called, "a number, such as 63 or 9.77e-6", "Correct it."
        ) from None


def _text(value: object) -> str:
    """Write a value so that it comes back the same; 63.0 is shown as 63."""
    if value is None:
        return ""
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)
