"""Which column of a log holds what, in which unit: from the headers, or as the user says."""

from __future__ import annotations

import difflib
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hdprog.data.numbers import is_number
from hdprog.data.roles import ROLES
from hdprog.errors import BadInputError
from hdprog.units import (
    ISO_8601,
    Unit,
    find_unit,
    known_units,
    normalise_name,
    parse_header,
)

__all__ = ["Column", "find_columns", "find_selection"]


_ISO_LIKE = re.compile(r"\s*\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}")
_REMARK = re.compile(r"(?<=\S)\s*(?:\[[^\[\]]*\]|\([^()]*\))\s*$")
_GIVEN = "in --columns or in [columns] of drive.toml"
# Torque and angle are those of the output, as measured: such a column is not to be put forward.
_NOT_MEASURED = frozenset(
    {"cmd", "command", "commanded", "control", "demand", "demanded", "desired", "input", "motor"}
    | {"ref", "reference", "set", "setpoint", "target"}
)


@dataclass(frozen=True)
class Column:
    """The column that holds one role: its place from 0, its header and its unit."""

    role: str
    index: int
    header: str
    unit: Unit


def find_columns(
    headers: Sequence[str],
    first_row: Sequence[str],
    columns: Mapping[str, str] | None,
    where: str,
) -> tuple[Column, ...]:
    """Find the column and the unit of each role.

    Parameters
    ----------
    headers : sequence of str
        The header cells.
    first_row : sequence of str
        The first row of data: dates and times in ISO 8601 need no unit.
    columns : mapping or None
        Role → ``HEADER:unit`` where the headers do not say it.
    where : str
        File and row of the header, for messages.

    Returns
    -------
    tuple of Column
        One for each role present; torque and angle always.

    Raises
    ------
    BadInputError
        The same column twice, one column of two dimensions, a missing column, a missing or
        unknown unit.
    """
    headers = [header.strip() for header in headers]
    if all(is_number(header.replace(",", ".")) for header in headers if header):
        raise BadInputError(
            "numbers: " + ", ".join(headers[:4]),
            where,
            "the names of the columns with their units, like torque_Nm,angle_rad",
            "Write such a row above the numbers. A header that begins with # passes for a comment: "
            "remove the sign.",
        )
    for header in headers:
        if header and headers.count(header) > 1:
            raise BadInputError(
                f"the column '{header}' twice",
                where,
                "each column once",
                "Rename or remove one of the two.",
            )
    found: list[Column] = []
    without_unit: list[tuple[str, str]] = []
    missing: list[str] = []
    for role, meaning in ROLES.items():
        given = (columns or {}).get(role)
        if given == "":
            continue
        if given is not None:
            index, unit_text = _given_column(headers, role, given, where)
        else:
            candidates = _candidates(headers, role)
            if len(candidates) > 1:
                names = " and ".join(f"'{headers[index]}'" for index in candidates)
                raise BadInputError(
                    f"more than one column for the {role}: {names}",
                    where,
                    "one",
                    f"Add {_option({role: headers[candidates[0]]})} to choose one.",
                )
            if not candidates:
                if meaning.required:
                    missing.append(role)
                continue
            index, unit_text = candidates[0], ""
        unit = _unit(headers[index], unit_text, role, where)
        # No number is a date: a header such as time_s leaves nothing to guess.
        if role == "time" and not unit_text and _is_iso(first_row, index):
            unit = ISO_8601
        if unit is None:
            without_unit.append((role, headers[index]))
        else:
            found.append(Column(role, index, headers[index], unit))
    if missing:
        raise _no_column(headers, missing, without_unit, where)
    if without_unit:
        if _row_of_units(headers, first_row, without_unit):
            raise _units_apart(headers, first_row, without_unit, where)
        raise _no_unit(without_unit, where)
    _refuse_shared(found, where)
    return tuple(found)


def _refuse_shared(found: Sequence[Column], where: str) -> None:
    """Refuse a column of two dimensions: torque over itself makes a loop, of 1 Nm/rad."""
    first: dict[int, Column] = {}
    for column in found:
        other = first.setdefault(column.index, column)
        if other.unit.dimension != column.unit.dimension:
            raise BadInputError(
                f"the column '{column.header}' as the {other.role} and as the {column.role}",
                where,
                "a column for each",
                f"Name the right ones with {_option({other.role: 'HEADER', column.role: 'HEADER'})}"
                ", or under [columns] in drive.toml.",
            )


def find_selection(
    headers: Sequence[str], select: Mapping[str, Sequence[str]] | None, where: str
) -> tuple[tuple[int, frozenset[str]], ...]:
    """Find the columns that rows are selected by; give each column's place and its values.

    Raises
    ------
    BadInputError
        A column that is not there.
    """
    return tuple(
        (_place([header.strip() for header in headers], name, where, "--select"), frozenset(values))
        for name, values in (select or {}).items()
    )


def _candidates(headers: Sequence[str], role: str) -> list[int]:
    found = []
    for index, text in enumerate(headers):
        header = parse_header(text)
        # A bare t is a time only where its unit says so.
        is_t = role == "time" and header.name == "t"
        if header.name in ROLES[role].names or (
            is_t and header.unit is not None and header.unit.dimension == "time"
        ):
            found.append(index)
    return found


def _place(headers: Sequence[str], name: str, where: str, option: str) -> int:
    if name in headers:
        return headers.index(name)
    folded = [header.casefold() for header in headers]
    if folded.count(name.casefold()) == 1:
        return folded.index(name.casefold())
    near = difflib.get_close_matches(name, headers, n=1)
    raise BadInputError(
        f"no column '{name}'",
        where,
        f"one of the columns that the file has: {_listed(headers)}",
        (f"Did you mean '{near[0]}'? " if near else "")
        + f"Correct {option}, or its table in drive.toml.",
    )


def _given_column(headers: Sequence[str], role: str, given: str, where: str) -> tuple[int, str]:
    """Return the place of the column that the user named, and the unit given with it."""
    name, colon, unit_text = (part.strip() for part in given.rpartition(":"))
    if given.strip() in headers or not colon:
        return _place(headers, given.strip(), where, "--columns"), ""
    return _place(headers, name or role, where, "--columns"), unit_text


def _unit(header: str, given: str, role: str, where: str) -> Unit | None:
    """Return the unit of a column, None where nothing says it."""
    dimension = ROLES[role].dimension
    written = parse_header(header)
    place = f"{where}, column '{header}'"
    expected = f"a unit of {dimension}: {', '.join(known_units(dimension))}"
    advice = f"Give the right one with {_option({role: f'{header}:UNIT'})}, or in the header."
    if not given:
        if not written.unit_text:
            return None
        if written.unit is None or written.unit.dimension != dimension:
            raise BadInputError(f"the unit '{written.unit_text}'", place, expected, advice)
        return written.unit
    unit = find_unit(given)
    if unit is None or unit.dimension != dimension:
        raise BadInputError(f"the unit '{given}' {_GIVEN}", place, expected, advice)
    if written.unit is not None and written.unit.dimension == dimension and written.unit != unit:
        raise BadInputError(
            f"the unit {written.unit.name} in the header and {unit.name} {_GIVEN}",
            place,
            "one unit",
            "Leave the unit out there, or rename the column.",
        )
    return unit


def _is_iso(first_row: Sequence[str], index: int) -> bool:
    return index < len(first_row) and _ISO_LIKE.match(first_row[index]) is not None


def _listed(headers: Sequence[str]) -> str:
    named = [f"'{header}'" for header in headers if header]
    rest = f" and {len(named) - 12} more" if len(named) > 12 else ""
    return ", ".join(named[:12]) + rest


def _option(columns: Mapping[str, str]) -> str:
    text = ",".join(f"{role}={column}" for role, column in columns.items())
    if re.fullmatch(r"[\w.,:=/+-]*", text):
        return f"--columns {text}"
    if not re.search(r'["$`\\]', text):
        return f'--columns "{text}"'
    return f"--columns {shlex.quote(text)}"  # double quotation marks would not keep these


def _example(role: str, header: str) -> str:
    dimension = ROLES[role].dimension
    # Another unit than the header's would be refused, or read wrong where a remark follows it.
    for text in (header, _REMARK.sub("", header)):
        written = parse_header(text).unit
        if written is not None and written.dimension == dimension:
            return f"{header}:{written.name}"
    return f"{header}:{known_units(dimension)[0]}"


def _no_unit(without: Sequence[tuple[str, str]], where: str) -> BadInputError:
    named = " and ".join(f"'{header}'" for _, header in without)
    units = "; ".join(
        f"{role}: {', '.join(known_units(ROLES[role].dimension))}" for role, _ in without
    )
    optional = [role for role, _ in without if not ROLES[role].required]
    leave_out = f" To leave a column out: {_option(dict.fromkeys(optional, ''))}." * bool(optional)
    return BadInputError(
        f"no unit for {named}",
        where,
        "the unit in the header, like torque_Nm or Torque [Nm]",
        f"Add {_option({role: _example(role, header) for role, header in without})} with the "
        f"units that it was recorded in ({units}), or write them into the header.{leave_out}",
    )


def _row_of_units(
    headers: Sequence[str], row: Sequence[str], without: Sequence[tuple[str, str]]
) -> bool:
    """Tell whether the row below the header gives units to all columns that lack one."""
    return all(_unit_below(headers, row, header) is not None for _, header in without)


def _unit_below(headers: Sequence[str], row: Sequence[str], header: str) -> Unit | None:
    index = headers.index(header)
    return find_unit(row[index].strip().strip("[]()")) if index < len(row) else None


def _units_apart(
    headers: Sequence[str],
    row: Sequence[str],
    without: Sequence[tuple[str, str]],
    where: str,
) -> BadInputError:
    """Return the error for units in a row of their own: --columns alone would not do."""
    units = [row[headers.index(header)].strip() for _, header in without]
    examples = [
        f"{header} [{unit.strip('[]()')}]" for (_, header), unit in zip(without, units, strict=True)
    ]
    return BadInputError(
        f"a row of units below the header ({', '.join(units)})",
        where,
        "the units in the header itself, like torque_Nm or Torque [Nm]",
        f"Write {' and '.join(examples)} there, and remove the row of units.",
    )


def _similar(headers: Sequence[str], role: str) -> str | None:
    """The one column that the role may be; None where it is none, or one of several."""
    found = []
    for header in headers:
        words = normalise_name(header).split("_")
        taken = any(_candidates([header], other) for other in ROLES if other != role)
        if role in words and not taken and _NOT_MEASURED.isdisjoint(words):
            found.append(header)
    return found[0] if len(found) == 1 else None


def _no_column(
    headers: Sequence[str],
    missing: Sequence[str],
    without_unit: Sequence[tuple[str, str]],
    where: str,
) -> BadInputError:
    examples = {role: _example(role, header) for role, header in without_unit}
    for role in missing:
        examples[role] = _example(role, _similar(headers, role) or "HEADER")
    return BadInputError(
        f"no column for the {' and the '.join(missing)} among {_listed(headers)}",
        where,
        " and ".join(f"{role}_{known_units(ROLES[role].dimension)[0]}" for role in missing)
        + ", or another name and unit that are known",
        f"Say which column it is, and its unit, with {_option(examples)} (or the same as "
        "[columns] in drive.toml). If lines stand above the row with the columns' names, remove "
        "them or begin them with #.",
    )
