"""What hdprog raises when it stops on purpose, with words for the person who has to act.

Every such error carries the exit code of the command line. Anything else that escapes is a bug
and ends with exit code 1.
"""

from __future__ import annotations

import errno
import os

__all__ = ["BadInputError", "HdprogError", "UsageError", "no_room", "shown_argument"]

_NO_ROOM = frozenset({errno.EDQUOT, errno.EFBIG, errno.ENOSPC})
# SQLITE_FULL, and SQLITE_IOERR_SHMSIZE, where the file that connections share finds no room.
_SQLITE_FULL = frozenset({13, 4874})
_POSTGRES_FULL = "53100"  # disk_full, among the error codes of its manual


class HdprogError(Exception):
    """Base of every error that hdprog raises on purpose."""

    exit_code = 1


class UsageError(HdprogError):
    """A command, option or argument was used wrongly (exit code 2)."""

    exit_code = 2


class BadInputError(HdprogError):
    """A file or a value cannot be used; nothing was written (exit code 3).

    Parameters
    ----------
    found : str
        What is there, as a noun phrase: ``"the text 'n/a'"``.
    where : str
        File, row (counted from 1 as an editor shows it) and column.
    expected : str
        What would have been right, as a noun phrase: ``"a number"``.
    advice : str
        One or more full sentences: what to do now.

    Notes
    -----
    ``str(error)`` is one paragraph made of all four.
    """

    exit_code = 3

    def __init__(self, found: str, where: str, expected: str, advice: str) -> None:
        # All four go to args, so that the error survives pickling between processes.
        super().__init__(found, where, expected, advice)
        self.found = found
        self.where = where
        self.expected = expected
        self.advice = advice

    def __str__(self) -> str:
        advice = self.advice[:1].upper() + self.advice[1:]
        end = "" if advice.endswith((".", "?", "!")) else "."
        return f"{self.where}: found {self.found}; expected {self.expected}. {advice}{end}"


def no_room(error: BaseException) -> str | None:
    """Say that a disk or a quota is full, which is no mistake of the program.

    Parameters
    ----------
    error : of the system, of a database, or of SQLAlchemy, which keeps a database's in ``orig``

    Returns
    -------
    str or None
        The words of the system or the database; None where an error is another one.
    """
    if isinstance(error, OSError):
        return os.strerror(error.errno) if error.errno in _NO_ROOM else None
    told = getattr(error, "orig", error)
    full = getattr(told, "sqlite_errorcode", None) in _SQLITE_FULL
    full = full or getattr(told, "sqlstate", None) == _POSTGRES_FULL
    return str(told).strip() if full else None


def shown_argument(given: object) -> str:
    """What was given to a function, in short, to be quoted by a message."""
    if isinstance(given, str | os.PathLike):
        return repr(str(given))
    if given is None or isinstance(given, int | float):
        return repr(given)
    return f"an object of type {type(given).__name__}"
