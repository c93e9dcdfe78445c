"""How a command ends: every error becomes words on standard error and an exit code."""

from __future__ import annotations

import errno
import os
import shlex
import signal
import sys
import threading
import traceback
from collections.abc import Sequence
from enum import IntEnum
from types import FrameType
from typing import Any

import typer
from typer.core import TyperGroup

from hdprog.errors import HdprogError, no_room


class ExitCode(IntEnum):
    """What the exit code of `hdprog` means."""

    DONE = 0
    BUG = 1
    USAGE = 2
    BAD_INPUT = 3
    NOT_CONVERGED = 4
    HUNG_UP = 129
    INTERRUPTED = 130
    BROKEN_PIPE = 141
    TERMINATED = 143


# What the machine or its user refuses, as opposed to a mistake in the program.
_REFUSED = {
    errno.EACCES,
    errno.EDQUOT,
    errno.EIO,
    errno.EISDIR,
    errno.ENAMETOOLONG,
    errno.ENOENT,
    errno.ENOSPC,
    errno.ENOTDIR,
    errno.EPERM,
    errno.EROFS,
}


class GuardedGroup(TyperGroup):
    """A group of commands whose errors end in words, never in a traceback nobody asked for."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Keep the command as it was typed, for the provenance in reports."""
        if args[:1] != ["check"]:  # which writes nothing
            _require_text(args)
        ctx.obj = shlex.join(["hdprog", *args])
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command; turn what goes wrong into words and an exit code."""
        _received.clear()
        if threading.current_thread() is threading.main_thread():
            for sign in ending_signals():
                signal.signal(sign, _end)
            if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
                signal.signal(signal.SIGINT, _interrupt)
        try:
            outcome = super().invoke(ctx)
            sys.stdout.flush()
        except (typer.Exit, typer.Abort, typer.TyperException):
            raise
        except BrokenPipeError as error:
            # The reader has gone; what Python would still flush at exit goes nowhere.
            _discard_standard_output()
            raise typer.Exit(ExitCode.BROKEN_PIPE) from error
        except KeyboardInterrupt as error:
            raise _interrupted() from error
        except Exception as error:
            if _received:
                raise _ended_by(_received[0]) from error
            if os.environ.get("HDPROG_DEBUG") == "1":
                traceback.print_exc()
            code, words = explain_error(error)
            typer.echo(words, err=True)
            raise typer.Exit(code) from error
        return outcome


def _require_text(args: Sequence[str]) -> None:
    """Refuse names that no report could hold, before the work."""
    for text in args:
        shown = text.encode("utf-8", "backslashreplace").decode()
        if any("\ud800" <= letter <= "\udfff" for letter in text):
            raise typer.BadParameter(
                f"found a name that is not UTF-8 ({shown}), expected one whose letters a report "
                "can show. Rename the file or folder."
            )


def explain_error(error: Exception) -> tuple[ExitCode, str]:
    """Say in words what an error means to the user, and give its exit code."""
    if isinstance(error, HdprogError):
        return ExitCode(error.exit_code), f"Error: {error}"
    if isinstance(error, OSError) and error.errno in _REFUSED and error.filename is not None:
        return ExitCode.BAD_INPUT, (
            f"Error: {error.filename}: {error.strerror}. The file or folder must be there, be "
            "readable, and be writable where hdprog writes; give another path, or change its "
            "permissions or free space."
        )
    if (full := no_room(error)) is not None:
        return ExitCode.BAD_INPUT, f"Error: {full}: {_words_of_full(error)}"
    return ExitCode.BUG, (
        f"hdprog stopped through a mistake of its own, not of your data: "
        f"{type(error).__name__}: {error} ({_place(error)}).\n"
        "Please report it: this message, the command, the output of `hdprog --version`, and what "
        "the same command prints with the environment variable HDPROG_DEBUG=1."
    )


def _words_of_full(error: Exception) -> str:
    if not isinstance(error, OSError):
        return (
            "found no room in the store's database; expected room in the data folder, or where the "
            "database's server keeps its files. Nothing was changed. Free space or raise the "
            "limit, and run the command again."
        )
    return (  # a write does not name its file
        "found no room for what was to be written; expected room for the results where --out "
        "points, or where standard output goes. Nothing half-written was left behind. Free space "
        "or raise the limit, or give another folder with --out DIR, and run the command again."
    )


def _place(error: Exception) -> str:
    """Name the innermost line of the project that the error passed through."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if f"{os.sep}hdprog{os.sep}" in frame.filename]
    if not ours:
        return "outside hdprog"
    file = ours[-1].filename
    return f"{file[file.rindex(f'hdprog{os.sep}') :]}, line {ours[-1].lineno}"


def ending_signals() -> tuple[signal.Signals, ...]:
    """Signals that tell a command to end; a terminal that closes does, unless nohup ignores it."""
    closed = getattr(signal, "SIGHUP", None)  # which Windows has not
    if closed is None or signal.getsignal(closed) == signal.SIG_IGN:
        return (signal.SIGTERM,)
    return (signal.SIGTERM, closed)


# Signals that told this command to end. What they raise may be lost: in the middle of a drawing,
# Matplotlib's compiled part raises an error of its own in its place.
_received: list[int] = []


def _end(number: int, _frame: object) -> None:
    """End as after an interrupt: what was begun aside is removed, worker processes stop."""
    _received.append(number)
    raise SystemExit(ExitCode(128 + number))


def _interrupt(number: int, frame: FrameType | None) -> None:
    _received.append(number)
    signal.default_int_handler(number, frame)


def _interrupted() -> typer.Exit:
    typer.echo(
        "Interrupted: nothing half-written was left behind. Run the command again: a fleet "
        "keeps the drives that are finished, anything else starts over.",
        err=True,
    )
    return typer.Exit(ExitCode.INTERRUPTED)


def _ended_by(number: int) -> typer.Exit:
    return _interrupted() if number == signal.SIGINT else typer.Exit(ExitCode(128 + number))


def _discard_standard_output() -> None:
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
    except (OSError, ValueError):  # standard output is no file, as under a test
        pass
