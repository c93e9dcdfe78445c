"""The texts of the options --columns and --select, taken apart."""

from __future__ import annotations

import re

from hdprog.data.roles import ROLES
from hdprog.errors import UsageError

__all__ = ["parse_columns", "parse_select"]


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
