"""What `hdprog check` says of a loop file or a drive folder, before anything is fitted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

from hdprog.config import Drive, read_drive
from hdprog.data.copied_records import copy_doubt, readings_doubt
from hdprog.data.drive_folder import require_drive_folder
from hdprog.data.loads_of_tests import load_doubts
from hdprog.data.loop import Loop
from hdprog.data.order_of_tests import order_doubts
from hdprog.data.quality import Quality, assess
from hdprog.data.read_off import figures_of
from hdprog.data.readers import parse_columns, parse_select, read_loop
from hdprog.data.tests_table import DriveTest, read_tests
from hdprog.errors import BadInputError
from hdprog.physics.figures import ARCMIN_PER_RAD

__all__ = ["CheckReport", "check_path"]

_NAMED = 6  # columns left aside that are told by name
_READ_OFF = {
    "hysteresis_width_arcmin": "width {:.3g} arcmin at zero torque",
    "hysteresis_loss_J": "loss {:.3g} J a cycle",
    "lost_motion_arcmin": "lost motion {:.3g} arcmin",
}


@dataclass(frozen=True)
class CheckReport:
    """Findings about one path.

    Parameters
    ----------
    path : Path
        What was checked.
    kind : {"loop", "drive"}
        A loop file or a drive folder.
    lines : tuple of str
        All findings in plain words, in order, problems and warnings among them.
    problems : tuple of str
        What has to be put right before the path is of use.
    warnings : tuple of str
        What deserves a second look.
    loops : tuple of (str, Quality)
        The usable loops: name of the test (or of the file), and what it holds.
    """

    path: Path
    kind: Literal["loop", "drive"]
    lines: tuple[str, ...]
    problems: tuple[str, ...]
    warnings: tuple[str, ...]
    loops: tuple[tuple[str, Quality], ...] = ()

    @property
    def ok(self) -> bool:
        """Whether no problem was found."""
        return not self.problems

    def as_json(self) -> dict[str, Any]:
        """Return the findings as JSON knows them, numbers in SI."""
        return {
            "path": str(self.path),
            "kind": self.kind,
            "ok": self.ok,
            "problems": list(self.problems),
            "warnings": list(self.warnings),
            "loops": [{"name": name, **_as_json(quality)} for name, quality in self.loops],
        }


def check_path(
    path: str | Path,
    columns: Mapping[str, str] | str | None = None,
    select: Mapping[str, Sequence[str]] | str | None = None,
    drive: Drive | str | Path | None = None,
) -> CheckReport:
    """Read a loop file or a drive folder, and say what was found and what is wrong.

    Parameters
    ----------
    path : str or Path
        A loop file or a drive folder.
    columns, select : mapping, str or None
        As in `hdprog.data.readers.read_loop`; they go before those of the drive.
    drive : Drive, path or None
        What a loop file is compared with. A drive folder has its own, which then holds.

    Raises
    ------
    BadInputError
        The file given as `drive` is wrong. What is wrong with `path` is in the report.
    UsageError
        The text of `columns` or `select` makes no sense.
    """
    path = Path(path)
    columns = parse_columns(columns) if isinstance(columns, str) else columns
    select = parse_select(select) if isinstance(select, str) else select
    settings = read_drive(drive) if isinstance(drive, str | Path) else drive
    if path.is_dir():
        return _check_folder(path, columns, select)
    notes = _Notes()
    _check_loop(notes, path.name, path, columns, select, settings)
    return notes.report(path, "loop")


class _Notes:
    """Collects findings in the order in which they come up."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.problems: list[str] = []
        self.warnings: list[str] = []
        self.loops: list[tuple[str, Quality]] = []

    def problem(self, error: BadInputError) -> None:
        self.problems.append(str(error))
        self.lines.append(f"Problem: {error}")

    def warning(self, name: str, text: str) -> None:
        self.warnings.append(f"{name}: {text}")
        self.lines.append(f"  Warning: {text}")

    def report(self, path: Path, kind: Literal["loop", "drive"]) -> CheckReport:
        return CheckReport(
            path,
            kind,
            tuple(self.lines),
            tuple(self.problems),
            tuple(self.warnings),
            tuple(self.loops),
        )


def _check_loop(
    notes: _Notes,
    name: str,
    path: Path,
    columns: Mapping[str, str] | None,
    select: Mapping[str, Sequence[str]] | None,
    drive: Drive | None,
) -> Loop | None:
    try:
        loop = read_loop(path, columns=columns, select=select, drive=drive)
    except BadInputError as error:
        notes.problem(error)
        return None
    quality = assess(loop, drive)
    quality = replace(quality, read_off=figures_of(loop, drive, quality.torque_noise))
    notes.loops.append((name, quality))
    first, *others = _facts(quality)
    notes.lines.append(f"{name}: {first}")
    notes.lines.extend(f"  {line}" for line in others)
    if loop.unread:
        notes.lines.append(f"  {_not_read(loop.unread)}")
    for warning in quality.warnings:
        notes.warning(name, warning)
    return loop


def _check_folder(
    path: Path,
    columns: Mapping[str, str] | None,
    select: Mapping[str, Sequence[str]] | None,
) -> CheckReport:
    notes = _Notes()
    drive: Drive | None = None
    tests: tuple[DriveTest, ...] = ()
    try:
        require_drive_folder(path)
        drive = read_drive(path)
    except BadInputError as error:
        notes.problem(error)
        if not (path / "drive.toml").is_file():
            return notes.report(path, "drive")
    try:
        tests, problems = read_tests(path)
        for problem in problems:
            notes.problem(problem)
    except BadInputError as error:
        notes.problem(error)
    if drive is None:
        # Without the drive's columns the loops would be found wanting for no fault of theirs.
        return notes.report(path, "drive")
    limits = f"{len(drive.limits)} {'limit' if len(drive.limits) == 1 else 'limits'}"
    number = f"{len(tests)} {'test' if len(tests) == 1 else 'tests'}"
    notes.lines.append(f"Drive {drive.id}: {number}, {limits}.")
    if not drive.limits:
        notes.warning(drive.id, "Without [[limits]] in drive.toml nothing can be forecast.")
    for found in (order_doubts(tests), load_doubts(tests)):
        for name, doubt in found.items():
            notes.warning(name, doubt)
    before: dict[str, tuple[str, str]] = {}
    for test in tests:
        loop = _check_loop(notes, test.test_id, test.path, columns, select, drive)
        if loop is None:
            continue
        copied = copy_doubt(test, tests), readings_doubt(loop, test.test_id, before)
        for doubt in filter(None, copied):
            notes.warning(test.test_id, doubt)
    return notes.report(path, "drive")


def _facts(quality: Quality) -> list[str]:
    """Say in words what a usable loop holds."""
    lines = [
        f"usable: {quality.samples} samples, {quality.cycles:.1f} {quality.sides} cycles, torque "
        f"{_range(quality.torque_min, quality.torque_max, '.4g')} Nm",
        f"Angle span {quality.angle_span:.3g} rad "
        f"({quality.angle_span * ARCMIN_PER_RAD:.3g} arcmin), "
        f"secant stiffness about {quality.secant_stiffness:.3g} Nm/rad",
        f"Noise: torque {quality.torque_noise:.2g} Nm{_step(quality.torque_step, 'Nm')}, angle "
        f"{quality.angle_noise:.2g} rad{_step(quality.angle_step, 'rad')}",
    ]
    if quality.read_off:
        read = [_READ_OFF[key].format(value) for key, value in quality.read_off.items()]
        lines.append(f"Read off it, no model in between: {', '.join(read)}")
    if quality.duration is None:
        lines.append("Untimed")
    else:
        rates = _range(min(quality.loading_rates), max(quality.loading_rates), ".2g")
        lines.append(
            f"{quality.duration:.4g} s long, loaded at {rates} Nm/s on average over a branch"
        )
    if quality.temperature_min is not None and quality.temperature_max is not None:
        lines.append(
            f"Temperature {_range(quality.temperature_min, quality.temperature_max, '.1f')} °C"
        )
    return lines


def _not_read(headers: Sequence[str]) -> str:
    """Name the columns left aside: a time by another name is missed by nothing else."""
    some = ", ".join(f"'{header}'" for header in headers[:_NAMED])
    more = f" and {len(headers) - _NAMED} more" if len(headers) > _NAMED else ""
    return f"Not read: {'column' if len(headers) == 1 else 'columns'} {some}{more}"


def _range(low: float, high: float, form: str) -> str:
    """Say from where to where, once where both read alike, and no zero with a sign."""
    first, last = (f"{value:{form}}" for value in (low, high))
    first, last = ("0" if float(text) == 0 else text for text in (first, last))
    return first if first == last else f"{first} to {last}"


def _step(step: float | None, unit: str) -> str:
    return "" if step is None else f" (in steps of {step:.3g} {unit})"


def _as_json(quality: Quality) -> dict[str, Any]:
    content = asdict(quality)
    if not math.isfinite(quality.secant_stiffness):
        content["secant_stiffness"] = None
    return content
