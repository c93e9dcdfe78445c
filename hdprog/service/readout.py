"""What is in an uploaded record, in the words of `hdprog check`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hdprog.service.pictures import svg_of

READINGS = "readings"  # in what is kept of a read-out: their digest


@dataclass(frozen=True)
class ReadOut:
    """What was read.

    Attributes
    ----------
    problems : why the record cannot be used; empty where it can
    quality : what is kept of it: the numbers, the warnings, and all findings in the words of
        `hdprog check`
    picture : of the record, as an SVG
    """

    problems: tuple[str, ...]
    quality: Mapping[str, Any]
    picture: str = ""


def read_record(path: Path, name: str, content: Mapping[str, Any]) -> ReadOut:
    """Read a record, in this process.

    Parameters
    ----------
    path : of the bytes
    name : what the user calls the file, to stand in the words
    content : of the drive's drive.toml
    """
    from hdprog.config import drive_from_mapping
    from hdprog.data.check import check_path
    from hdprog.data.copied_records import digest_of_readings
    from hdprog.data.readers import read_loop
    from hdprog.reporting.figures.raw_loop import raw_loop

    drive = drive_from_mapping(content)
    found = check_path(path, drive=drive)

    def called(text: str) -> str:
        return text.replace(str(path), name).replace(path.name, name)

    if not found.ok:
        return ReadOut(tuple(map(called, found.problems)), {})
    numbers = found.as_json()["loops"][0]
    numbers.pop("name")
    loop = read_loop(path, drive=drive)
    kept = {**numbers, "lines": list(map(called, found.lines)), READINGS: digest_of_readings(loop)}
    return ReadOut((), kept, svg_of(raw_loop(loop)))


def refused(name: str, found: str, expected: str) -> ReadOut:
    """Refuse a record that could not be read to its end."""
    words = (
        f"{name}: found {found}; expected {expected}. Upload the record of one test as CSV, or "
        "keep every tenth row of it."
    )
    return ReadOut((words,), {})
