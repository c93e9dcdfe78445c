"""The texts of the options --columns and --select, taken apart."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from hdprog.data.roles import ROLES
from hdprog.errors import UsageError

__all__ = ["given_columns", "given_selection", "parse_columns", "parse_select"]


def given_columns(columns: Mapping[str, str] | str | None) -> Mapping[str, str] | None:
    """Columns as a caller gives them, as text or by role.

    Raises
    ------
    UsageError
        As `parse_columns`, or a role that is none, or what is no text of a column.
    """
    if columns is None or isinstance(columns, str):
        return None if columns is None else parse_columns(columns)
    form = f"Write columns={{'torque': 'HEADER:Nm', ...}} with roles {', '.join(ROLES)}."
    if not isinstance(columns, Mapping):
        raise UsageError(
            f"columns: found an object of type {type(columns).__name__}, expected a mapping of "
            f"roles to columns. {form}"
        )
    for role, column in columns.items():
        if role not in ROLES or not isinstance(column, str):
            raise UsageError(
                f"columns: found {role!r}: {column!r}; expected a role and 'HEADER:unit'. {form}"
            )
    return columns


def given_selection(
    select: Mapping[str, Sequence[str]] | str | None,
) -> Mapping[str, tuple[str, ...]] | None:
    """Selection as a caller gives it, as text or by column; numbers count as their text.

    Raises
    ------
    UsageError
        As `parse_select`, or what is no mapping.
    """
    if select is None or isinstance(select, str):
        return None if select is None else parse_select(select)
    if not isinstance(select, Mapping):
        raise UsageError(
            f"select: found an object of type {type(select).__name__}, expected a mapping of "
            "columns to values. Write select={'COLUMN': ['VALUE', 'VALUE']}."
        )
    return {column: _values(values) for column, values in select.items()}


def _values(values: object) -> tuple[str, ...]:
    """One value or several, as text: ``"100,101"`` are two, as in a drive's file."""
    if isinstance(values, str):
        return tuple(value.strip() for value in values.split(","))
    if isinstance(values, Iterable):
        return tuple(str(value) for value in values)
    return (str(values),)


def parse_columns(text: str) -> dict[str, str]:
    """Take the text of ``--columns`` apart.

    Parameters
    ----------
    text : str
        ``torque=TORQUE:Nm,angle=POSITION:rev,time=TIME:s``; an empty header leaves an optional
        role out.

    Returns
    -------
    dict
        Role → ``HEADER:unit``.

    Raises
    ------
    UsageError
        A part without ``=``, an unknown role, or a role given twice.
    """
    form = f"Write --columns torque=HEADER:Nm,angle=HEADER:rad with roles {', '.join(ROLES)}."
    found: dict[str, str] = {}
    for part in re.split(r",(?=\s*\w+\s*=)", text):
        role, equals, column = (piece.strip() for piece in part.partition("="))
        if not equals or role not in ROLES or (not column and ROLES[role].required):
            raise UsageError(
                f"--columns: found {part.strip()!r}; expected role=HEADER:unit. {form}"
            )
        if role in found:
            raise UsageError(f"--columns: found {role} twice; expected each role once. {form}")
        found[role] = column
    return found


def parse_select(text: str) -> dict[str, tuple[str, ...]]:
    """Take the text of ``--select`` apart.

    Parameters
    ----------
    text : str
        ``test_nr=100,101,102``; a further ``name=`` begins a further column, and rows have to
        satisfy all of them.

    Returns
    -------
    dict
        Column → values of the rows to keep.

    Raises
    ------
    UsageError
        No ``=``, a column without values, or a column given twice.
    """
    form = "Write --select COLUMN=VALUE,VALUE."
    found: dict[str, tuple[str, ...]] = {}
    for part in re.split(r"[,;](?=[^,;=]+=)", text):
        column, equals, listed = (piece.strip() for piece in part.partition("="))
        values = tuple(value.strip() for value in listed.split(",") if value.strip())
        if not equals or not column or not values:
            raise UsageError(
                f"--select: found {part.strip()!r}; expected a column and at least one value. "
                f"{form}"
            )
        if column in found:
            raise UsageError(f"--select: found {column} twice; expected each column once. {form}")
        found[column] = values
    return found
