"""What each value of a drive can be, by one rule for drive.toml and for settings made in Python."""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError

from hdprog.errors import BadInputError

STRICT = ConfigDict(strict=True, allow_inf_nan=False, extra="forbid")
_LEAST_ALPHA, _MOST_ALPHA = 5.0, 60.0  # degrees

Positive = Annotated[float, Field(gt=0)]
# A hundred times the largest gears, a thousand years: beyond is a slip of the keyboard.
Torque = Annotated[float, Field(gt=0, le=1e6)]
Hours = Annotated[float, Field(gt=0, le=1e7)]
Risk = Annotated[float, Field(gt=0, lt=1)]
Text = Annotated[str, Field(min_length=1, pattern=r"\S")]
ToothAngleDegrees = Annotated[float, Field(ge=_LEAST_ALPHA, le=_MOST_ALPHA)]
ToothAngle = Annotated[float, Field(ge=math.radians(_LEAST_ALPHA), le=math.radians(_MOST_ALPHA))]


def _as_values(found: object) -> object:
    """Accept one value, a list, or ``"100,101"`` for the values of a selection."""
    if isinstance(found, str):
        return tuple(part.strip() for part in found.split(","))
    if isinstance(found, list | tuple):
        return tuple(_as_value(part) for part in found)
    value = _as_value(found)
    return (value,) if isinstance(value, str) else found


def _as_value(found: object) -> object:
    """Write a number as its text; what is neither stays, to be refused."""
    whole = isinstance(found, int) and not isinstance(found, bool)
    return str(found) if whole or (isinstance(found, float) and math.isfinite(found)) else found


Values = Annotated[tuple[Text, ...], Field(min_length=1), BeforeValidator(_as_values)]
"""Values of a column whose rows are to be kept."""


class ColumnsTable(BaseModel):
    """Columns of a drive's logs by role, ``HEADER:unit``; empty leaves an optional one out."""

    model_config = STRICT

    torque: Text | None = None
    angle: Text | None = None
    time: str | None = None
    temperature: str | None = None
    output_angle: str | None = None


# What Pydantic's types of error mean to somebody who wrote the value by hand.
_EXPECTED = {
    "string_type": 'text in quotation marks, like "cell3-axis2"',
    "string_unicode": "text of whole signs",
    "string_too_short": "text that is not empty",
    "string_pattern_mismatch": "text that is not empty",
    "float_type": "a number without quotation marks",
    "finite_number": "a finite number",
    "model_type": "a table with keys of its own",
    "dict_type": "a table with keys of its own",
    "list_type": "entries that each begin with [[limits]]",
    "tuple_type": "the values of the rows to keep, like [100, 101]",
    "too_short": "at least one value",
}
_ADVICE = {"alpha": "Give the tooth angle in rad: degrees as math.radians(30)."}


def expected_words(kind: str, bounds: Mapping[str, Any]) -> str:
    """What would have been right; empty for a kind of error that has no words here.

    Parameters
    ----------
    kind, bounds : Pydantic's type and context of an error
    """
    return _EXPECTED.get(kind) or " and ".join(
        words
        for words in (
            f"a number greater than {bounds['gt']:g}" if "gt" in bounds else "",
            f"a number less than {bounds['lt']:g}" if "lt" in bounds else "",
            f"a number of {bounds['ge']:g} or more" if "ge" in bounds else "",
            f"a number of {bounds['le']:g} or less" if "le" in bounds else "",
        )
        if words
    )


def check_fields(settings: Any) -> None:
    """Hold a frozen dataclass's fields against the rules that they are annotated with.

    Numbers of NumPy become plain ones, and whole ones floats, as a file's do.

    Raises
    ------
    BadInputError
        naming class and field
    """
    for name, rule in _rules_of(type(settings)).items():  # type: ignore[arg-type]
        given = getattr(settings, name)
        plain = isinstance(given, int | float | None) or not isinstance(given, numbers.Real)
        try:
            value = rule.validate_python(given if plain else float(given))
        except ValidationError as error:
            raise _refused(settings, name, error) from error
        object.__setattr__(settings, name, value)


def check_table(settings: Any, name: str, table: type[BaseModel]) -> None:
    """Hold a mapping of a frozen dataclass against the table of a file that it stands for.

    Raises
    ------
    BadInputError
        naming class and field
    """
    given = getattr(settings, name)
    try:
        found = table.model_validate(dict(given) if isinstance(given, Mapping) else given)
    except ValidationError as error:
        raise _refused(settings, name, error, table) from error
    object.__setattr__(settings, name, found.model_dump(exclude_none=True))


def _refused(
    settings: Any, name: str, error: ValidationError, table: type[BaseModel] | None = None
) -> BadInputError:
    detail = error.errors()[0]
    expected = expected_words(detail["type"], detail.get("ctx", {}))
    if table is not None and detail["type"] == "extra_forbidden":
        expected = "only " + ", ".join(table.model_fields)
    return BadInputError(
        f"{name}={getattr(settings, name)!r}",
        type(settings).__name__,
        expected or detail["msg"],
        _ADVICE.get(name, f"Correct {name}."),
    )


@cache
def _rules_of(settings: type) -> dict[str, TypeAdapter[Any]]:
    hints = get_type_hints(settings, include_extras=True)
    return {
        name: TypeAdapter(hint, config=STRICT) for name, hint in hints.items() if _is_ruled(hint)
    }


def _is_ruled(hint: object) -> bool:
    return get_origin(hint) is Annotated or any(map(_is_ruled, get_args(hint)))
